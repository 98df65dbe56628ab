//! What was found in a model, in words. Pure.

use core::fmt::Write;

use super::subject::Subject;
use crate::anim::clip::Clip;

/// The whole report, lines that end in a line feed.
pub(super) fn of(subject: &Subject) -> String {
    let Subject { name, rig, binding, walker, .. } = subject;
    let morphs = rig.meshes.iter().map(|mesh| mesh.morph_weights.len()).sum();
    let mut text = format!(
        "{name}: {}, {}, {}, {}, {}\n",
        count(rig.skeleton.len(), "joint"),
        count(rig.skins.len(), "skin"),
        count(rig.meshes.len(), "mesh"),
        count(morphs, "morph target"),
        count(rig.clips.len(), "clip"),
    );
    if !rig.expressions.is_empty() {
        let names: Vec<_> = rig.expressions.iter().map(|expression| expression.name.as_str()).collect();
        line(&mut text, &format!("  expressions: {}", names.join(", ")));
    }
    for clip in &rig.clips {
        line(&mut text, &clip_line(clip));
    }
    line(&mut text, binding.to_string().trim_end());
    for own in walker.iter().flat_map(|walker| &walker.own_clips) {
        line(&mut text, &own.to_string());
    }
    line(
        &mut text,
        &match walker {
            Ok(walker) => {
                let states: Vec<_> = walker.file.locomotion.states().iter().map(|state| state.name.as_str()).collect();
                let (states, scale) = (states.join(", "), walker.file.scale);
                let own_size = scale.to_bits() == 1f32.to_bits();
                let size =
                    if own_size { String::new() } else { format!(", {scale:.3} times as large to fit the course") };
                format!("it walks{size}; states: {states}")
            }
            // What the body lacks is told above.
            Err(_) if !binding.is_bound() => "it does not walk".to_owned(),
            Err(error) => format!("it does not walk: {error}"),
        },
    );
    text
}

fn clip_line(clip: &Clip) -> String {
    let Clip { name, duration, report, .. } = clip;
    let end = if clip.looping { "loops" } else { "ends" };
    format!(
        "  clip {name}: {duration:.2} s, {} at {:.0} Hz, {:.3} mm off its keys, {} kB, {end}",
        count(clip.frame_count(), "frame"),
        clip.frame_rate(),
        report.max_error * 1000.0,
        report.bytes.div_ceil(1000),
    )
}

fn count(number: usize, what: &str) -> String {
    match (number, what.strip_suffix("sh")) {
        (1, _) => format!("1 {what}"),
        (_, Some(_)) => format!("{number} {what}es"),
        (_, None) => format!("{number} {what}s"),
    }
}

fn line(text: &mut String, words: &str) {
    // Writing into a string does not fail.
    let _ = writeln!(text, "{words}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_a_kind_has_no_plural_and_a_mesh_an_own_one() {
        assert_eq!([count(1, "joint"), count(2, "joint"), count(3, "mesh")], ["1 joint", "2 joints", "3 meshes"]);
    }
}
