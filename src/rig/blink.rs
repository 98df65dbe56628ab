//! Which morph targets shut a model's eyes.

use super::{
    MeshBinding, Rig,
    expressions::ExpressionBind,
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

/// Expressions that shut both eyes.
const EXPRESSIONS: [&[&str]; 2] = [&["blink"], &["blinkLeft", "blinkRight"]];

/// What shuts the eyes of the rig: its expressions, or targets of its meshes.
///
/// # Errors
/// When the file names a target that no mesh has, and that is no expression.
pub(super) fn targets(config: &BlinkConfig, rig: &Rig) -> Result<Vec<ExpressionBind>, RangeError> {
    let expression = |wanted: &str| rig.expressions.iter().find(|expression| same(&expression.name, wanted));
    let shows = |wanted: &str| expression(wanted).is_some_and(|expression| !expression.binds.is_empty());
    let targets = || rig.meshes.iter().flat_map(|mesh| &mesh.morph_names).map(String::as_str);
    let has = |wanted: &str| targets().any(|name| same(name, wanted));
    let told = |name: &str| expression(name).into_iter().flat_map(|expression| expression.binds.clone());
    let of_name = |wanted: &str| -> Vec<ExpressionBind> {
        let of_mesh = |(mesh, binding): (usize, &MeshBinding)| {
            let shuts = |target: &usize| same(&binding.morph_names[*target], wanted);
            let bind = move |target: usize| ExpressionBind { mesh, target, weight: 1.0 };
            (0..binding.morph_names.len()).filter(shuts).map(bind).collect::<Vec<_>>()
        };
        rig.meshes.iter().enumerate().flat_map(of_mesh).collect()
    };
    let Some(wanted) = &config.targets else {
        if let Some(group) = EXPRESSIONS.into_iter().find(|group| group.iter().all(|name| shows(name))) {
            return Ok(group.iter().flat_map(|name| told(name)).collect());
        }
        let group = COMMON.into_iter().find(|group| group.iter().all(|name| has(name))).unwrap_or_default();
        return Ok(group.iter().flat_map(|name| of_name(name)).collect());
    };
    let names = || targets().chain(rig.expressions.iter().map(|expression| expression.name.as_str()));
    if let Some(unknown) = wanted.iter().find(|name| names().all(|other| !same(other, name))) {
        let what = if rig.expressions.is_empty() { "morph targets" } else { "morph targets and expressions" };
        let valid = format!("names of the model's {what}: {}{}", listed(names()), suggestion(unknown, names()));
        return Err(Ranges::new("blink.").fail("targets", format!("`{unknown}`"), valid));
    }
    Ok(wanted.iter().flat_map(|name| if has(name) { of_name(name) } else { told(name).collect() }).collect())
}

/// Tools differ in their capitals.
fn same(a: &str, b: &str) -> bool {
    a.eq_ignore_ascii_case(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::expressions::Expression;

    fn rig(meshes: &[&[&str]]) -> Rig {
        let mesh = |names: &&[&str]| MeshBinding {
            morph_names: names.iter().map(|name| (*name).to_owned()).collect(),
            ..MeshBinding::default()
        };
        Rig { meshes: meshes.iter().map(mesh).collect(), ..Rig::default() }
    }

    #[test]
    fn eyes_of_many_tools_are_found() {
        let found = |meshes: &[&[&str]]| {
            let binds = targets(&BlinkConfig::default(), &rig(meshes)).expect("nothing is asked for");
            let of_mesh = |mesh: usize| binds.iter().filter(move |bind| bind.mesh == mesh).map(|bind| bind.target);
            (0..meshes.len()).map(|mesh| of_mesh(mesh).collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        assert_eq!(found(&[&["breath"], &["smile", "Blink"]]), [vec![], vec![1]]);
        assert_eq!(
            found(&[&["eyesClosed", "eyeBlinkRight", "eyeBlinkLeft"], &["eyeBlinkLeft"]]),
            [vec![2, 1], vec![0]]
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

    #[test]
    fn expressions_that_shut_the_eyes_go_before_names_of_targets() {
        let mut rig = rig(&[&["blink", "lids"], &["lashes"]]);
        let binds = [(0, 1, 0.8), (1, 0, 1.0)].map(|(mesh, target, weight)| ExpressionBind { mesh, target, weight });
        let empty = Expression { name: "blink".to_owned(), ..Expression::default() };
        let wink = |name: &str| Expression { name: name.to_owned(), binds: binds.to_vec(), ..Expression::default() };
        let found = |rig: &Rig, config: &BlinkConfig| targets(config, rig).expect("names are good");
        rig.expressions = vec![empty];
        assert_eq!(found(&rig, &BlinkConfig::default()).len(), 1, "an expression that moves nothing shuts nothing");
        rig.expressions = vec![wink("blink")];
        assert_eq!(found(&rig, &BlinkConfig::default()), binds);
        rig.expressions = vec![wink("sleepy")];
        let config = BlinkConfig { targets: Some(vec!["sleepy".to_owned()]), ..BlinkConfig::default() };
        assert_eq!(found(&rig, &config), binds, "the file may name an expression");
    }
}
