//! Expressions of VRM models, of 1.0 and 0.x, good and broken.

use serde_json::{Value, json};
use surefoot::rig::{
    Rig,
    expressions::{Expression, Override},
};

use crate::gltf_file::{GltfFile, triangle};

/// A triangle with a face of two targets, `lids` and `smile`, shown by two nodes, and a VRM extension.
fn face(extension: &str, content: Value) -> GltfFile {
    let mut file = triangle();
    let moves = file.floats("VEC3", &[0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0]);
    let mesh = &mut file.root["meshes"][0];
    mesh["primitives"][0]["targets"] = json!([{ "POSITION": moves }, { "POSITION": moves }]);
    mesh["extras"] = json!({ "targetNames": ["lids", "smile"] });
    file.push("nodes", json!({ "name": "twin", "mesh": 0, "skin": 0 }));
    file.root["extensionsUsed"] = json!([extension]);
    file.root["extensions"] = json!({ extension: content });
    file
}

fn read(file: &GltfFile) -> Rig {
    Rig::from_slice(&file.glb(), |_| Err("no files".to_owned())).unwrap_or_else(|error| panic!("{error}"))
}

fn named<'a>(rig: &'a Rig, name: &str) -> &'a Expression {
    let names: Vec<_> = rig.expressions.iter().map(|expression| &expression.name).collect();
    rig.expressions.iter().find(|expression| expression.name == name).unwrap_or_else(|| panic!("{name} of {names:?}"))
}

/// Mesh, target and weight of all that an expression moves.
fn binds(expression: &Expression) -> Vec<(usize, usize, f32)> {
    expression.binds.iter().map(|bind| (bind.mesh, bind.target, bind.weight)).collect()
}

#[test]
fn expressions_of_vrm_1_are_read_by_their_names() {
    let bind = |node: usize, index: usize, weight: f32| json!({ "node": node, "index": index, "weight": weight });
    let file = face(
        "VRMC_vrm",
        json!({ "specVersion": "1.0", "expressions": {
            "preset": {
                "blink": { "morphTargetBinds": [bind(2, 0, 1.0), bind(3, 0, 0.5)] },
                "happy": { "morphTargetBinds": [bind(2, 1, 0.75)], "overrideBlink": "blend", "overrideMouth": "block" },
                "aa": { "isBinary": true },
            },
            "custom": { "smirk": { "morphTargetBinds": [bind(3, 1, 0.25)] } },
        }}),
    );
    let rig = read(&file);
    assert_eq!(rig.notes, [""; 0]);
    assert_eq!(rig.expressions.len(), 4);
    assert_eq!(binds(named(&rig, "blink")), [(0, 0, 1.0), (1, 0, 0.5)]);
    let happy = named(&rig, "happy");
    assert_eq!(binds(happy), [(0, 1, 0.75)]);
    assert_eq!((happy.blink, happy.mouth, happy.binary), (Override::Blend, Override::Block, false));
    assert!(named(&rig, "aa").binary && binds(named(&rig, "aa")).is_empty());
    assert_eq!(binds(named(&rig, "smirk")), [(1, 1, 0.25)]);
}

#[test]
fn expressions_of_vrm_0_go_by_the_names_of_vrm_1() {
    let group = |name: &str, preset: &str, index: usize, weight: f32| {
        let bind = json!({ "mesh": 0, "index": index, "weight": weight });
        json!({ "name": name, "presetName": preset, "binds": [bind], "isBinary": false })
    };
    let groups = [
        group("Joy", "joy", 1, 100.0),
        group("BlinkLeft", "blink_l", 0, 60.0),
        group("A", "a", 1, 50.0),
        group("Smirk", "unknown", 1, 25.0),
    ];
    let rig = read(&face("VRM", json!({ "blendShapeMaster": { "blendShapeGroups": groups } })));
    assert_eq!(rig.notes, [""; 0]);
    let names: Vec<_> = rig.expressions.iter().map(|expression| expression.name.as_str()).collect();
    assert_eq!(names, ["happy", "blinkLeft", "aa", "Smirk"]);
    // A mesh is meant wherever it is shown.
    assert_eq!(binds(named(&rig, "happy")), [(0, 1, 1.0), (1, 1, 1.0)]);
    assert_eq!(binds(named(&rig, "blinkLeft")), [(0, 0, 0.6), (1, 0, 0.6)]);
    assert_eq!(binds(named(&rig, "Smirk")), [(0, 1, 0.25), (1, 1, 0.25)]);
}

#[test]
fn what_is_wrong_with_an_expression_is_named_and_left_out() {
    let good = json!({ "node": 2, "index": 1, "weight": 1.0 });
    for (bad, said) in [
        (json!({ "node": 2, "index": 7, "weight": 1.0 }), "node `body` has no morph target 7; there are 2"),
        (json!({ "node": 99, "index": 0, "weight": 1.0 }), "node 99 does not exist; there are 4"),
        (json!({ "node": 1, "index": 0, "weight": 1.0 }), "node `tip` draws no mesh"),
        (json!({ "node": -1, "index": 0, "weight": 1.0 }), "its `node` is no index"),
        (json!({ "node": 2, "weight": 1.0 }), "its `index` is no index"),
        (json!({ "node": 2, "index": 0, "weight": 1e39 }), "its weight is not a finite number"),
        (json!({ "node": 2, "index": 0, "weight": "1" }), "its weight is not a finite number"),
    ] {
        let content = json!({ "expressions": { "preset": { "happy": { "morphTargetBinds": [bad, good] } } } });
        let rig = read(&face("VRMC_vrm", content));
        let note = format!("`VRMC_vrm.expressions.preset.happy.morphTargetBinds[0]`: {said}; it is left out");
        assert_eq!(rig.notes, [note]);
        assert_eq!(binds(named(&rig, "happy")), [(0, 1, 1.0)], "the rest of the expression stays");
    }
    let groups = json!([
        { "name": "Joy", "presetName": "joy", "binds": [{ "mesh": 4, "index": 0, "weight": 100.0 }] },
        { "name": "Joy", "presetName": "joy", "binds": [{ "mesh": 0, "index": 0, "weight": 130.0 }] },
        { "binds": "none" },
    ]);
    let rig = read(&face("VRM", json!({ "blendShapeMaster": { "blendShapeGroups": groups } })));
    assert_eq!(
        rig.notes,
        [
            "`VRM.blendShapeMaster.blendShapeGroups[0].binds[0] (`happy`)`: mesh 4 does not exist; there are 1; it is left out",
            "`VRM.blendShapeMaster.blendShapeGroups[1].binds[0] (`happy`)`: its weight 1.3 is not from 0 to 1; the nearest is \
             taken",
            "`VRM.blendShapeMaster.blendShapeGroups[1]`: there is another of its name; it is left out",
            "`VRM.blendShapeMaster.blendShapeGroups[2]`: it has no name; it is left out",
        ]
    );
    assert_eq!(rig.expressions.len(), 1);
}

#[test]
fn extensions_of_the_wrong_shape_bring_no_expressions() {
    for content in
        [json!({ "expressions": 3 }), json!({ "expressions": { "preset": [], "custom": { "a": 1 } } }), json!([])]
    {
        let rig = read(&face("VRMC_vrm", content.clone()));
        assert!(
            rig.expressions.iter().all(|expression| expression.binds.is_empty()),
            "{content}: {:?}",
            rig.expressions
        );
    }
}
