//! Every element of a file made wrong, one at a time: it loads, or is refused in words, and nothing panics.

use std::panic::{AssertUnwindSafe, catch_unwind};

use serde_json::Value;
use surefoot::rig::{
    binding::BindingReport,
    character::CharacterAsset,
    character_file::{CharacterFile, Roles},
};

use super::*;

/// Loads, binds and makes a character; `Err` is what was said against it.
fn take(glb: &[u8]) -> Result<(), String> {
    let rig = Rig::from_slice(glb, no_files).map_err(|error| error.to_string())?;
    let text = BindingReport::new(&rig, &Roles::Auto).to_string();
    assert!(text.len() > 20, "a report of `{text}`");
    let file = CharacterFile::parse("(standard_clips: false)").expect("the text is good");
    let others = std::collections::BTreeMap::new();
    CharacterAsset::resolve(file, "x.glb".into(), rig, &others).map(|_| ()).map_err(|error| error.to_string())
}

/// Paths of all values below `value`, itself included.
fn places(value: &Value, path: &str, out: &mut Vec<String>) {
    out.push(path.to_owned());
    match value {
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(index, item)| places(item, &format!("{path}/{index}"), out));
        }
        Value::Object(fields) => fields.iter().for_each(|(name, item)| places(item, &format!("{path}/{name}"), out)),
        _ => {}
    }
}

#[test]
fn no_wrong_value_anywhere_makes_it_panic() {
    let good = Body::default().build();
    assert_eq!(take(&good.glb()), Ok(()));
    let mut all = Vec::new();
    places(&good.root, "", &mut all);
    let wrong = [json!(null), json!(-1), json!(4_294_967_295u32), json!(1e30), json!("x"), json!([]), json!({})];
    let (mut tried, mut refused) = (0, 0);
    for place in all.iter().filter(|place| !place.is_empty()) {
        for value in &wrong {
            let mut file = good.clone();
            *file.root.pointer_mut(place).expect("the place is in the file") = value.clone();
            let taken = catch_unwind(AssertUnwindSafe(|| take(&file.glb())));
            let taken = taken.unwrap_or_else(|_| panic!("{place} = {value} panics"));
            tried += 1;
            if let Err(message) = taken {
                refused += 1;
                assert!(message.len() > 10, "{place} = {value} is refused with `{message}`");
            }
        }
    }
    assert!(tried > 2000 && refused > tried / 4, "{refused} of {tried} refused");
}

#[test]
fn no_number_in_the_buffer_makes_it_panic() {
    let good = Body::default().build();
    for value in [f32::NAN, f32::INFINITY, -1e30, 0.0] {
        for at in (0..good.bin.len() - 4).step_by(4) {
            let mut file = good.clone();
            file.bin[at..at + 4].copy_from_slice(&value.to_le_bytes());
            let taken = catch_unwind(AssertUnwindSafe(|| take(&file.glb())));
            assert!(taken.is_ok(), "{value} at byte {at} of the buffer panics");
        }
    }
}

#[test]
fn bodies_squashed_to_nothing_are_refused_in_words() {
    for scale in [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1e-20, 1e-20, 1e-20], [1e20, 1e20, 1e20]] {
        let mut file = Body::default().build();
        file.root["nodes"][0]["scale"] = json!(scale);
        let taken = catch_unwind(AssertUnwindSafe(|| take(&file.glb())));
        assert!(taken.is_ok(), "a root scaled by {scale:?} panics");
    }
    let mut file = Body::default().build();
    file.root["nodes"][3]["translation"] = json!([0.0, 0.0, 0.0]);
    let message = take(&file.glb()).expect_err("a thigh has no length");
    assert!(message.contains("leftLowerLeg") && message.contains("no length"), "{message}");
}
