//! Names: taking joint names of many tools apart, and finding what a misspelt name meant.

/// A side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

/// A joint's name without prefix and side: `mixamorig:LeftUpLeg` → left, `upleg`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct JointName {
    pub(super) side: Option<Side>,
    pub(super) key: String,
}

/// Words that tools put before a joint's own name.
const FILLERS: [&str; 20] = [
    "mixamorig",
    "bip",
    "j",
    "jnt",
    "joint",
    "def",
    "org",
    "bone",
    "bn",
    "b",
    "c",
    "cc",
    "base",
    "armature",
    "skeleton",
    "rig",
    "character",
    "valve",
    "biped",
    "sk",
];
/// Words that tools put behind it.
const TRAILERS: [&str; 6] = ["joint", "jnt", "bone", "bn", "bind", "skin"];

impl JointName {
    /// Lower case, split at separators, capitals and digits; fillers and side taken out.
    pub(super) fn parse(name: &str) -> Self {
        let own = name.rsplit([':', '|']).next().unwrap_or(name);
        let mut side = None;
        let mut words: Vec<String> = Vec::new();
        let mut after_filler = false;
        for word in words_of(own) {
            let word_side = match word.as_str() {
                "left" | "l" | "lft" => Some(Side::Left),
                "right" | "r" | "rgt" => Some(Side::Right),
                _ => None,
            };
            let number = word.bytes().all(|byte| byte.is_ascii_digit());
            if let (Some(found), None) = (word_side, side) {
                side = Some(found);
            } else if words.is_empty() && FILLERS.contains(&word.as_str()) {
                after_filler = true;
                continue;
            } else if number && after_filler && words.is_empty() {
                // `Bip01 Pelvis`, `mixamorig1:Hips`: the number counts characters, not joints.
            } else if number {
                words.push(word.trim_start_matches('0').to_owned());
            } else {
                words.push(word);
            }
            after_filler = false;
        }
        while words.len() > 1 && words.last().is_some_and(|word| TRAILERS.contains(&word.as_str())) {
            words.pop();
        }
        Self { side, key: words.concat() }
    }
}

pub(super) fn words_of(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    let mut letters = name.chars().peekable();
    while let Some(letter) = letters.next() {
        // `RLeg` is a side and a leg.
        let new_word = before.is_lowercase() || letters.peek().is_some_and(|next| next.is_lowercase());
        let starts = !letter.is_alphanumeric()
            || letter.is_uppercase() && before.is_alphabetic() && new_word
            || letter.is_ascii_digit() != before.is_ascii_digit();
        if starts {
            words.push(String::new());
        }
        if letter.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// How many names a message lists before it stops.
const LISTED: usize = 60;

/// `names` for a message: quoted, sorted, cut short when there are very many.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    names.sort();
    names.dedup();
    if names.is_empty() {
        return "none".to_owned();
    }
    let more = names.len().saturating_sub(LISTED);
    names.truncate(LISTED);
    let list = names.join(", ");
    if more > 0 { format!("{list} and {more} more") } else { list }
}

/// ` (did you mean …?)` with the name nearest to `wrong`, or nothing when none is near.
pub(super) fn suggestion<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let nearest = names.into_iter().map(|name| (edit_distance(wrong, name), name)).min_by_key(|near| near.0);
    match nearest {
        Some((distance, name)) if distance <= wrong.chars().count().max(3) / 2 => {
            format!(" (did you mean `{name}`?)")
        }
        _ => String::new(),
    }
}

/// Letters to insert, remove or change between two names, capitals aside.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            let change = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = change.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_tools_come_apart() {
        for (name, side, key) in [
            ("leftUpperLeg", Some(Side::Left), "upperleg"),
            ("mixamorig:LeftUpLeg", Some(Side::Left), "upleg"),
            ("mixamorig1:RightToeBase", Some(Side::Right), "toebase"),
            ("mixamorigHips", None, "hips"),
            ("mixamorig_Hips", None, "hips"),
            ("thigh_l", Some(Side::Left), "thigh"),
            ("spine_01", None, "spine1"),
            ("DEF-thigh.L", Some(Side::Left), "thigh"),
            ("DEF-thigh.L.001", Some(Side::Left), "thigh1"),
            ("UpperArm.R", Some(Side::Right), "upperarm"),
            ("upperleg.l", Some(Side::Left), "upperleg"),
            ("J_Bip_L_UpperLeg", Some(Side::Left), "upperleg"),
            ("J_Bip_C_Hips", None, "hips"),
            ("Bip01 R Calf", Some(Side::Right), "calf"),
            ("Bip001 Pelvis", None, "pelvis"),
            ("ik_foot_l", Some(Side::Left), "ikfoot"),
            ("Armature|Hips", None, "hips"),
            ("lShin", Some(Side::Left), "shin"),
            ("LThigh", Some(Side::Left), "thigh"),
            ("left_upLeg_joint", Some(Side::Left), "upleg"),
            ("R_Foot_JNT", Some(Side::Right), "foot"),
            ("ValveBiped.Bip01_L_Thigh", Some(Side::Left), "thigh"),
            ("CC_Base_L_ToeBase", Some(Side::Left), "toebase"),
            ("Left knee", Some(Side::Left), "knee"),
            ("Bone_07", None, ""),
        ] {
            let found = JointName::parse(name);
            assert_eq!((found.side, found.key.as_str()), (side, key), "{name}");
        }
    }

    #[test]
    fn a_misspelt_name_finds_its_neighbour() {
        let names = ["walk", "run", "idle"];
        assert_eq!(suggestion("wlak", names), " (did you mean `walk`?)");
        assert_eq!(suggestion("Run", names), " (did you mean `run`?)");
        assert_eq!(suggestion("swim_backwards", names), "");
        assert_eq!(listed(names), "`idle`, `run`, `walk`");
    }
}
