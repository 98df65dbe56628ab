//! What the model does: walk by itself, rest, or play a clip on the spot.
//!
//! Reads [`Playback`] and the model's clips; writes [`SkinPose`] and morph weights, which take the place of the character's own.

use bevy::prelude::*;

use super::subject::Viewed;
use crate::{
    anim::pose::Pose,
    character::schedule::PoseSystems,
    game::level::Hero,
    rig::Rig,
    skinning::{Morphs, SkinPose},
};

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::game) enum Show {
    /// What the character does by itself; the rest pose where it cannot walk.
    #[default]
    Own,
    /// The rest pose.
    Rest,
    /// The clip of this index.
    Clip(usize),
}

impl Show {
    /// The next thing to show of a model with `clips` clips, round and round; `step` 1 or -1.
    pub(in crate::game) fn stepped(self, clips: usize, step: isize) -> Self {
        let place = match self {
            Self::Own => 0,
            Self::Rest => 1,
            Self::Clip(clip) => clip + 2,
        };
        let places = isize::try_from(clips + 2).unwrap_or(isize::MAX);
        match isize::try_from(place).map_or(0, |place| (place + step).rem_euclid(places)) {
            0 => Self::Own,
            1 => Self::Rest,
            clip => Self::Clip(usize::try_from(clip - 2).unwrap_or(0)),
        }
    }
}

/// What is shown, and how far it is.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(in crate::game) struct Playback {
    /// What is shown.
    pub(in crate::game) show: Show,
    /// Seconds into the clip.
    pub(in crate::game) time: f32,
    /// What the face shows in full besides what the clip says.
    pub(in crate::game) face: Option<Face>,
}

/// What a face shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::game) enum Face {
    /// The morph target of this index.
    Target(usize),
    /// The expression of this index.
    Expression(usize),
}

impl Face {
    /// What to show after `face` of a model with so many of each; nothing after the last.
    pub(in crate::game) fn after(face: Option<Self>, targets: usize, expressions: usize) -> Option<Self> {
        let next = match face {
            None => 0,
            Some(Self::Target(target)) => target + 1,
            Some(Self::Expression(expression)) => targets + expression + 1,
        };
        match next.checked_sub(targets) {
            None => Some(Self::Target(next)),
            Some(expression) => (expression < expressions).then_some(Self::Expression(expression)),
        }
    }
}

pub(in crate::game) fn plugin(app: &mut App) {
    app.init_resource::<Playback>().add_systems(PostUpdate, pose.before(PoseSystems::Palette));
}

fn pose(
    playback: Res<Playback>,
    viewed: Res<Viewed>,
    mut heroes: Query<(Entity, Option<&mut SkinPose>, Option<&mut Morphs>), With<Hero>>,
    mut commands: Commands,
) {
    for (hero, pose, morphs) in &mut heroes {
        if playback.show == Show::Own && viewed.walks {
            if pose.is_some() {
                commands.entity(hero).remove::<SkinPose>();
                if let Some(mut morphs) = morphs {
                    morphs.release_all();
                }
            }
            continue;
        }
        let posed = posed(&viewed.rig, playback.show, playback.time);
        match pose {
            Some(mut pose) => pose.0 = posed,
            None => {
                commands.entity(hero).insert(SkinPose(posed));
            }
        }
        if let Some(mut morphs) = morphs {
            morph(&mut morphs, &viewed.rig, &playback);
        }
    }
}

/// The pose of a clip at `time` seconds, or the rest pose.
pub(in crate::game) fn posed(rig: &Rig, show: Show, time: f32) -> Pose {
    let mut pose = Pose::rest(&rig.skeleton);
    if let Show::Clip(clip) = show
        && let Some(clip) = rig.clips.get(clip)
    {
        clip.sample(&rig.skeleton, time, pose.locals_mut());
        pose.update_model(&rig.skeleton);
    }
    pose
}

/// Weights of the clip, if its targets are those of the model; then the one that is held.
fn morph(morphs: &mut Morphs, rig: &Rig, playback: &Playback) {
    let names = morphs.names().to_vec();
    names.iter().for_each(|name| {
        morphs.set(name, 0.0);
    });
    for mesh in &rig.meshes {
        let mut weights = mesh.morph_weights.clone();
        if let Show::Clip(clip) = playback.show
            && let Some(clip) = rig.clips.get(clip)
        {
            clip.morph_weights(mesh.joint, playback.time, &mut weights);
        }
        for (name, weight) in mesh.morph_names.iter().zip(weights) {
            morphs.set(name, weight);
        }
    }
    match playback.face {
        Some(Face::Target(target)) => {
            if let Some(name) = names.get(target) {
                morphs.set(name, 1.0);
            }
        }
        Some(Face::Expression(expression)) => {
            for bind in rig.expressions.get(expression).iter().flat_map(|expression| &expression.binds) {
                if let Some(name) = rig.meshes.get(bind.mesh).and_then(|mesh| mesh.morph_names.get(bind.target)) {
                    morphs.set(name, bind.weight);
                }
            }
        }
        None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_shows_each_target_and_then_each_expression() {
        let (mut face, mut seen) = (None, vec![]);
        for _ in 0..4 {
            face = Face::after(face, 2, 1);
            seen.push(face);
        }
        let expected = [Some(Face::Target(0)), Some(Face::Target(1)), Some(Face::Expression(0)), None];
        assert_eq!(seen, expected);
        assert_eq!(Face::after(None, 0, 0), None, "a model without a face shows none");
    }

    #[test]
    fn stepping_leads_through_all_clips_and_round() {
        let mut show = Show::Own;
        let mut seen = vec![];
        for _ in 0..4 {
            show = show.stepped(2, 1);
            seen.push(show);
        }
        assert_eq!(seen, [Show::Rest, Show::Clip(0), Show::Clip(1), Show::Own]);
        assert_eq!(Show::Own.stepped(2, -1), Show::Clip(1));
    }
}
