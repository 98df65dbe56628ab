//! Everything a character needs, as one plugin group.

use bevy::{app::PluginGroupBuilder, prelude::*};

use crate::{
    character::{
        aim::AimPlugin, animator::AnimatorPlugin, attach::AttachPlugin, bind::BindPlugin, chains::ChainsPlugin,
        detail::DetailPlugin, ease::EasePlugin, foot_ik::FootIkPlugin, locomotion::LocomotionPlugin, look::LookPlugin,
        motion::MotionPlugin, schedule::SchedulePlugin, show::ShowPlugin,
    },
    rig::loader::RigPlugin,
};

/// Everything a character needs: loading, controller, locomotion, animation, foot IK, and with the feature `render` its
/// skin on the GPU.
///
/// Add it after `DefaultPlugins` (or `MinimalPlugins`, `TransformPlugin` and `AssetPlugin`) and avian's `PhysicsPlugins`.
pub struct SurefootPlugins;

impl PluginGroup for SurefootPlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>()
            .add(SchedulePlugin)
            .add(RigPlugin)
            .add(BindPlugin)
            .add(MotionPlugin)
            .add(LocomotionPlugin)
            .add(DetailPlugin)
            .add(AnimatorPlugin)
            .add(FootIkPlugin)
            .add(LookPlugin)
            .add(AimPlugin)
            .add(ChainsPlugin)
            .add(EasePlugin)
            .add(ShowPlugin)
            .add(AttachPlugin);
        #[cfg(feature = "render")]
        let group = group.add(crate::skinning::SkinningPlugin::default());
        group
    }
}
