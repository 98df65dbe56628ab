//! Which morph targets shut a model's eyes.

use super::{
    MeshBinding, Rig,
    names::{listed, suggestion},
    tuning::{
        blink::BlinkConfig,
        ranges::{RangeError, Ranges},
    },
};

/// Targets that shut both eyes, by the names that many tools give; the first that a model has in full are its own.
const COMMON: [&[&str]; 7] = [
    &["blink"],
    &["Fcl_EYE_Close"],
    &["eyeBlinkLeft", "eyeBlinkRight"],
    &["eyeBlink_L", "eyeBlink_R"],
    &["blinkLeft", "blinkRight"],
    &["blink_L", "blink_R"],
    &["eyesClosed"],
];

/// For each of the rig's meshes the targets, by index, that shut the eyes.
///
/// # Errors
/// When the file names a target that no mesh has.
pub(super) fn targets(config: &BlinkConfig, rig: &Rig) -> Result<Vec<Vec<usize>>, RangeError> {
    let names = || rig.meshes.iter().flat_map(|mesh| &mesh.morph_names).map(String::as_str);
    let has = |wanted: &str| names().any(|name| same(name, wanted));
    let wanted: Vec<&str> = match &config.targets {
        None => COMMON.into_iter().find(|group| group.iter().all(|name| has(name))).unwrap_or_default().to_vec(),
        Some(targets) => targets.iter().map(String::as_str).collect(),
    };
    if let Some(unknown) = wanted.iter().find(|name| !has(name)) {
        let valid = format!("names of the model's morph targets: {}{}", listed(names()), suggestion(unknown, names()));
        return Err(Ranges::new("blink.").fail("targets", format!("`{unknown}`"), valid));
    }
    let of_mesh = |mesh: &MeshBinding| {
        let shuts = |target: &usize| wanted.iter().any(|name| same(&mesh.morph_names[*target], name));
        (0..mesh.morph_names.len()).filter(shuts).collect()
    };
    Ok(rig.meshes.iter().map(of_mesh).collect())
}

/// Tools differ in their capitals.
fn same(a: &str, b: &str) -> bool {
    a.eq_ignore_ascii_case(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(meshes: &[&[&str]]) -> Rig {
        let mesh = |names: &&[&str]| MeshBinding {
            morph_names: names.iter().map(|name| (*name).to_owned()).collect(),
            ..MeshBinding::default()
        };
        Rig { meshes: meshes.iter().map(mesh).collect(), ..Rig::default() }
    }

    #[test]
    fn eyes_of_many_tools_are_found() {
        let found = |meshes: &[&[&str]]| targets(&BlinkConfig::default(), &rig(meshes)).expect("nothing is asked for");
        assert_eq!(found(&[&["breath"], &["smile", "Blink"]]), [vec![], vec![1]]);
        assert_eq!(
            found(&[&["eyesClosed", "eyeBlinkRight", "eyeBlinkLeft"], &["eyeBlinkLeft"]]),
            [vec![1, 2], vec![0]]
        );
        assert_eq!(found(&[&["eyeBlinkLeft"]]), [vec![0; 0]], "one eye alone winks");
        assert_eq!(found(&[&[]]), [vec![0; 0]], "a model without targets has nothing to blink with");
    }

    #[test]
    fn a_target_that_is_not_there_is_named_with_the_nearest() {
        let config = BlinkConfig { targets: Some(vec!["wink".to_owned()]), ..BlinkConfig::default() };
        let error = targets(&config, &rig(&[&["smile", "blink"]])).expect_err("it can't wink");
        assert_eq!(
            error.to_string(),
            "`blink.targets` is `wink`; valid is names of the model's morph targets: `blink`, `smile` (did you mean `blink`?)"
        );
    }
}
