//! What tools call the joints of a body.

/// Tools that [`named_by`] knows.
pub(super) const TOOLS: [&str; 9] =
    ["vrm", "vroid", "mixamo", "unity", "unreal", "rigify", "blender", "kaykit", "biped"];

/// A part, and what a tool calls it.
type Table = &'static [(&'static str, &'static str)];

const MIXAMO: Table = &[
    ("hips", "Hips"),
    ("spine", "Spine"),
    ("chest", "Spine1"),
    ("neck", "Neck"),
    ("head", "Head"),
    ("Shoulder", "Shoulder"),
    ("UpperArm", "Arm"),
    ("LowerArm", "ForeArm"),
    ("Hand", "Hand"),
    ("UpperLeg", "UpLeg"),
    ("LowerLeg", "Leg"),
    ("Foot", "Foot"),
    ("Toes", "ToeBase"),
];
const UNITY: Table = &[
    ("UpperArm", "arm"),
    ("LowerArm", "elbow"),
    ("Hand", "wrist"),
    ("UpperLeg", "leg"),
    ("LowerLeg", "knee"),
    ("Foot", "ankle"),
    ("Toes", "toe"),
    ("Shoulder", "shoulder"),
];
const UNREAL: Table = &[
    ("hips", "pelvis"),
    ("spine", "spine_01"),
    ("chest", "spine_02"),
    ("neck", "neck_01"),
    ("head", "head"),
    ("Shoulder", "clavicle"),
    ("UpperArm", "upperarm"),
    ("LowerArm", "lowerarm"),
    ("Hand", "hand"),
    ("UpperLeg", "thigh"),
    ("LowerLeg", "calf"),
    ("Foot", "foot"),
    ("Toes", "ball"),
];
const RIGIFY: Table = &[
    ("hips", "DEF-spine"),
    ("spine", "DEF-spine.001"),
    ("chest", "DEF-spine.002"),
    ("neck", "DEF-spine.004"),
    ("head", "DEF-spine.006"),
    ("Shoulder", "DEF-shoulder"),
    ("UpperArm", "DEF-upper_arm"),
    ("LowerArm", "DEF-forearm"),
    ("Hand", "DEF-hand"),
    ("UpperLeg", "DEF-thigh"),
    ("LowerLeg", "DEF-shin"),
    ("Foot", "DEF-foot"),
    ("Toes", "DEF-toe"),
];
const BIPED: Table = &[
    ("hips", "Pelvis"),
    ("spine", "Spine"),
    ("chest", "Spine1"),
    ("neck", "Neck"),
    ("head", "Head"),
    ("Shoulder", "Clavicle"),
    ("UpperArm", "UpperArm"),
    ("LowerArm", "Forearm"),
    ("Hand", "Hand"),
    ("UpperLeg", "Thigh"),
    ("LowerLeg", "Calf"),
    ("Foot", "Foot"),
    ("Toes", "Toe0"),
];

/// A tool's own name for what VRM calls `leftUpperLeg` and so on.
pub(super) fn named_by(tool: &str, role: &str) -> String {
    let (side, part) = match (role.strip_prefix("left"), role.strip_prefix("right")) {
        (Some(part), _) => ("Left", part),
        (_, Some(part)) => ("Right", part),
        _ => ("", role),
    };
    let of = |table: Table| table.iter().find(|row| row.0 == part).map(|row| row.1);
    let letter = side.chars().next().map(|letter| letter.to_ascii_lowercase());
    let dotted =
        |name: &str| letter.map_or(name.to_owned(), |letter| format!("{name}.{}", letter.to_ascii_uppercase()));
    let tool_name = match tool {
        "vrm" => Some(role.to_owned()),
        "vroid" => {
            let middle = letter.map_or('C', |letter| letter.to_ascii_uppercase());
            let part = if part == "Toes" { "ToeBase" } else { part };
            let (first, rest) = part.split_at(1);
            Some(format!("J_Bip_{middle}_{}{rest}", first.to_uppercase()))
        }
        "mixamo" => of(MIXAMO).map(|name| format!("mixamorig:{side}{name}")),
        "unity" => of(UNITY).map(|name| format!("{side} {name}")).or_else(|| Some(role.to_owned())),
        "unreal" => of(UNREAL).map(|name| letter.map_or(name.to_owned(), |letter| format!("{name}_{letter}"))),
        "rigify" => of(RIGIFY).map(dotted),
        "blender" => Some(dotted(part)),
        "kaykit" => {
            let name = part.to_lowercase();
            Some(letter.map_or(name.clone(), |letter| format!("{name}.{letter}")))
        }
        "biped" => of(BIPED).map(|name| {
            letter.map_or(format!("Bip01 {name}"), |letter| format!("Bip01 {} {name}", letter.to_ascii_uppercase()))
        }),
        _ => None,
    };
    tool_name.unwrap_or_else(|| format!("{tool}_{role}"))
}
