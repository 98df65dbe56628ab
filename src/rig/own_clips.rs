//! Which of a model's own clips play in the standard states, told by their names: `Walking_A`, `Armature|Run`, `Robot_Idle`.
//!
//! Only what goes on and on is taken: standing, gaits, falling. A jump or a turn has to fit the controller to a tenth of a
//! second and is taken only under the state's own name.

use core::fmt;

use bevy::math::Vec3;

use super::{character::CharacterClip, names::words_of};

/// A clip and the standard state's clip that its name says it is.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnClip {
    /// The name that states use.
    pub state: &'static str,
    /// The clip's own name.
    pub clip: String,
    /// Why it isn't taken nevertheless; `None`: it is.
    pub refused: Option<Refusal>,
}

/// Why a clip isn't what its name says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// Its last pose is not its first.
    Ends,
    /// Its feet go at this speed over ground, in m/s, where they shall stand.
    Goes(f32),
    /// Its feet don't go at all, or not the way they shall.
    GoesElsewhere,
    /// One of its feet never stands.
    Hovers,
}

impl fmt::Display for OwnClip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { state, clip, refused } = self;
        match refused {
            None => write!(f, "`{state}` is its own clip `{clip}`"),
            Some(refusal) => write!(f, "`{clip}` is called like `{state}` but {refusal}"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ends => write!(f, "does not end as it begins"),
            Self::Goes(speed) => write!(f, "has feet that go at {speed:.1} m/s"),
            Self::GoesElsewhere => write!(f, "has feet that don't go that way"),
            Self::Hovers => write!(f, "has a foot that never stands"),
        }
    }
}

/// Speed over ground, in lengths of the leg per second, below which feet stand.
const STANDS: f32 = 0.15;
/// Cosine of the widest angle between the way that a gait shall go and the way it goes.
const SAME_WAY: f32 = 0.8;

/// Gives those of `clips` whose names say so the names of standard states, too; tells which.
pub(super) fn adopt(clips: &mut Vec<CharacterClip>, leg_length: f32) -> Vec<OwnClip> {
    let told = told_by_name(clips, leg_length);
    for own in told.iter().filter(|own| own.refused.is_none()) {
        let clip = clips.iter().find(|clip| clip.name == own.clip).cloned();
        clips.extend(clip.map(|clip| CharacterClip { name: own.state.to_owned(), ..clip }));
    }
    told
}

/// For each standard clip that `clips` lack, the clip whose name says most plainly that it is that.
fn told_by_name(clips: &[CharacterClip], leg_length: f32) -> Vec<OwnClip> {
    let words: Vec<Vec<String>> = clips.iter().map(|clip| words_of(&clip.name)).collect();
    // `Robot_Walking`, `Robot_Idle`: the model's name says nothing.
    let says_nothing = |word: &String| words.len() > 1 && words.iter().all(|others| others.contains(word));
    let mut found: Vec<(usize, OwnClip)> = Vec::new();
    for (clip, words) in clips.iter().zip(&words) {
        let told: Vec<&str> = words.iter().filter(|word| !says_nothing(word)).map(String::as_str).collect();
        let Some(state) = state_of(&told).filter(|state| clips.iter().all(|other| other.name != *state)) else {
            continue;
        };
        let own = OwnClip { state, clip: clip.name.clone(), refused: refusal(state, clip, leg_length) };
        let rank = |length: usize, own: &OwnClip| (own.refused.is_some(), length, own.clip.clone());
        match found.iter_mut().find(|(_, other)| other.state == state) {
            Some((length, other)) if rank(told.len(), &own) < rank(*length, other) => {
                (*length, *other) = (told.len(), own);
            }
            Some(_) => {}
            None => found.push((told.len(), own)),
        }
    }
    found.sort_by_key(|(_, own)| own.state);
    found.into_iter().map(|(_, own)| own).collect()
}

fn refusal(state: &str, clip: &CharacterClip, leg_length: f32) -> Option<Refusal> {
    let way = match state {
        "fall" => return None,
        "idle" | "crouch_idle" => Vec3::ZERO,
        "walk_back" | "crouch_back" => Vec3::Z,
        "strafe_left" | "crouch_left" => Vec3::NEG_X,
        "strafe_right" | "crouch_right" => Vec3::X,
        _ => Vec3::NEG_Z,
    };
    let (speed, goes) = (clip.gait.speed, clip.gait.speed > STANDS * leg_length);
    if !clip.clip.looping {
        Some(Refusal::Ends)
    } else if way == Vec3::ZERO {
        goes.then_some(Refusal::Goes(speed))
    } else if !goes || clip.gait.velocity.dot(way) < SAME_WAY * speed {
        Some(Refusal::GoesElsewhere)
    } else {
        clip.gait.contact.iter().any(Vec::is_empty).then_some(Refusal::Hovers)
    }
}

/// What a word of a clip's name tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Word {
    Stand,
    Walk,
    Run,
    Sprint,
    Crouch,
    Sneak,
    Strafe,
    Jump,
    Fall,
    Forward,
    Back,
    Left,
    Right,
    /// Nothing: `Walk_Loop`, `Walking_A`.
    Filler,
}

fn word_of(word: &str) -> Option<Word> {
    let number = word.bytes().all(|byte| byte.is_ascii_digit());
    Some(match word {
        "idle" | "idling" => Word::Stand,
        "walk" | "walking" | "walks" | "walkcycle" => Word::Walk,
        "run" | "running" | "runs" | "runcycle" | "jog" | "jogging" => Word::Run,
        "sprint" | "sprinting" => Word::Sprint,
        "crouch" | "crouched" | "crouching" => Word::Crouch,
        "sneak" | "sneaking" => Word::Sneak,
        "strafe" | "strafing" | "sidestep" => Word::Strafe,
        "jump" | "jumping" => Word::Jump,
        "fall" | "falling" => Word::Fall,
        "forward" | "forwards" | "fwd" => Word::Forward,
        "back" | "backward" | "backwards" | "bwd" => Word::Back,
        "left" | "l" => Word::Left,
        "right" | "r" => Word::Right,
        "a" | "anim" | "animation" | "action" | "armature" | "base" | "basic" | "breathing" | "clip" | "cycle"
        | "default" | "in" | "inplace" | "layer" | "loop" | "looped" | "looping" | "neutral" | "normal" | "place"
        | "rig" | "skeleton" | "standard" | "standing" | "unarmed" => Word::Filler,
        _ if number || word.len() == 1 => Word::Filler,
        _ => return None,
    })
}

/// The clip of the standard states that these words name; `None` when one of them says something else.
fn state_of(words: &[&str]) -> Option<&'static str> {
    let mut told = words.iter().map(|word| word_of(word)).collect::<Option<Vec<Word>>>()?;
    told.retain(|word| *word != Word::Filler);
    told.sort_unstable();
    told.dedup();
    Some(match told.as_slice() {
        [Word::Stand] => "idle",
        [Word::Walk] | [Word::Walk, Word::Forward] => "walk",
        [Word::Run] | [Word::Run, Word::Forward] => "run",
        [Word::Sprint] | [Word::Sprint, Word::Forward] => "sprint",
        [Word::Crouch] | [Word::Stand, Word::Crouch] => "crouch_idle",
        [Word::Sneak]
        | [Word::Walk, Word::Sneak]
        | [Word::Crouch, Word::Forward]
        | [Word::Walk, Word::Crouch]
        | [Word::Walk, Word::Crouch, Word::Forward] => "crouch_walk",
        [Word::Crouch, Word::Back] | [Word::Walk, Word::Crouch, Word::Back] => "crouch_back",
        [Word::Crouch, Word::Left]
        | [Word::Walk, Word::Crouch, Word::Left]
        | [Word::Crouch, Word::Strafe, Word::Left] => "crouch_left",
        [Word::Crouch, Word::Right]
        | [Word::Walk, Word::Crouch, Word::Right]
        | [Word::Crouch, Word::Strafe, Word::Right] => "crouch_right",
        [Word::Walk, Word::Back] => "walk_back",
        [Word::Strafe, Word::Left] | [Word::Walk, Word::Left] | [Word::Walk, Word::Strafe, Word::Left] => "strafe_left",
        [Word::Strafe, Word::Right] | [Word::Walk, Word::Right] | [Word::Walk, Word::Strafe, Word::Right] => {
            "strafe_right"
        }
        [Word::Fall] | [Word::Stand, Word::Fall] | [Word::Stand, Word::Jump] => "fall",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_packs_tell_the_state() {
        for (name, state) in [
            ("Walking_A", Some("walk")),
            ("Rig|Walking_B", Some("walk")),
            ("Walk", Some("walk")),
            ("walk.001", Some("walk")),
            ("WalkForward_Loop", Some("walk")),
            ("Armature|Run|BaseLayer", Some("run")),
            ("Jog_Fwd", Some("run")),
            ("Sprinting", Some("sprint")),
            ("Breathing Idle", Some("idle")),
            ("Idle_A", Some("idle")),
            ("Crouch_Idle_Loop", Some("crouch_idle")),
            ("Sneaking", Some("crouch_walk")),
            ("Crouch_Fwd", Some("crouch_walk")),
            ("Walking_Backwards", Some("walk_back")),
            ("Strafe Left", Some("strafe_left")),
            ("Walk_R", Some("strafe_right")),
            ("Crouched Walking", Some("crouch_walk")),
            ("Jump_Idle", Some("fall")),
            ("Falling Idle", Some("fall")),
            // What says more than that is something else.
            ("Jump", None),
            ("WalkJump", None),
            ("Run_Shoot", None),
            ("Idle_Gun", None),
            ("Strafe", None),
            ("Turn Left", None),
            ("Dance", None),
            ("mixamo.com", None),
            ("A", None),
        ] {
            let words = words_of(name);
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            assert_eq!(state_of(&words), state, "{name}");
        }
    }
}
