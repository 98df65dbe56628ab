//! States of character files: the standard ones, listed ones, and what is wrong with them.

use crate::{
    character_file::{fault, resolve},
    gltf_file::Body,
};

#[test]
fn standard_states_without_a_clip_are_left_out_with_their_transitions() {
    let asset = resolve("(standard_clips: false)", &Body::default()).expect("idle, walk and run are enough");
    let states: Vec<_> = asset.file.locomotion.states().iter().map(|state| state.name.as_str()).collect();
    assert_eq!(states, ["idle", "walk", "run", "strafe"]);
    assert_eq!(asset.file.locomotion.states()[3].blend, ["walk", "run"]);
    for transition in asset.file.locomotion.transitions() {
        for name in transition.from.iter().chain([&transition.to]) {
            assert!(states.contains(&name.as_str()), "a transition is left that names {name}");
        }
    }
}

#[test]
fn states_that_are_listed_need_all_their_clips() {
    let states = r#"states: [(name: "go", blend: ["walk", "sidle"], pace: Gait(start_phase: 0.0))]"#;
    assert_eq!(
        fault(&format!("(locomotion: ({states}, transitions: []))")),
        "`locomotion.states` has `go` play the clip `sidle`, which doesn't exist (did you mean `idle`?); \
         clips: `idle`, `run`, `walk`, `wave`"
    );
    for (states, message) in [
        (r#"(name: "go")"#, "`locomotion.states[0].clip` is empty; valid is either a clip or a blend"),
        (
            r#"(name: "go", clip: "walk", blend: ["run"])"#,
            "`locomotion.states[0].clip` is there beside `blend`; valid is either a clip or a blend",
        ),
        (
            r#"(name: "go", clip: "walk", pace: Turn(angle: 0.0))"#,
            "`locomotion.states[0].pace.angle` is 0°; valid is a turn to the left or right",
        ),
        (
            r#"(name: "go", clip: "walk"), (name: "go", clip: "run")"#,
            "`locomotion.states[1].name` is `go`; valid is a name of its own",
        ),
    ] {
        assert_eq!(fault(&format!("(locomotion: (states: [{states}]))")), message);
    }
}

#[test]
fn a_list_of_states_alone_keeps_the_standard_transitions_between_them() {
    let text = r#"(locomotion: (states: [(name: "idle", clip: "idle"), (name: "walk", clip: "walk", pace: Gait(start_phase: 0.2))]))"#;
    let asset = resolve(text, &Body::default()).expect("two states are enough");
    let ways: Vec<_> = asset.file.locomotion.transitions().iter().map(|t| (t.from.len(), t.to.as_str())).collect();
    assert_eq!(ways, [(1, "walk"), (1, "idle")]);
}
