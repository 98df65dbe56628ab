//! What one may tune of an [`OrbitCamera`](super::OrbitCamera).

use bevy::prelude::*;

/// How an [`OrbitCamera`](super::OrbitCamera) follows.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component)]
pub struct OrbitCameraConfig {
    /// Metres above the target's feet that the camera looks at. Default 1.45.
    ///
    /// Low: more ground in view. Above the head: the character sinks in the picture.
    pub pivot_height: f32,
    /// Metres that the arm's root stands to the right of the target at the shortest zoom; none at the longest. Default 0.35.
    pub shoulder: f32,
    /// Seconds in which the pivot makes up half of its way to the target on the plan. Default 0.05.
    ///
    /// Short: stiff. Long: the target runs ahead in the picture.
    pub follow_half_life: f32,
    /// The same for height. Default 0.16.
    ///
    /// Short: stairs shake the picture. Long: jumps leave it.
    pub climb_half_life: f32,
    /// Seconds in which half of a turn is done. Default 0.018.
    ///
    /// Short: direct. Long: heavy.
    pub orbit_half_life: f32,
    /// Seconds in which half of a zoom is done. Default 0.09.
    pub zoom_half_life: f32,
    /// Shortest arm in metres. Default 1.5.
    pub nearest: f32,
    /// Longest arm in metres. Default 12.
    pub farthest: f32,
    /// Factor by which one step of zoom shortens the arm. Default 0.86.
    pub zoom_step: f32,
    /// Lowest pitch in radians: below 0 the camera looks up from under the pivot. Default -35°.
    pub lowest_pitch: f32,
    /// Highest pitch in radians. Default 75°.
    pub highest_pitch: f32,
    /// Seconds of the target's motion that the pivot looks ahead. Default 0.12.
    pub look_ahead: f32,
    /// Most metres of look-ahead. Default 0.8.
    pub most_look_ahead: f32,
    /// Seconds in which half of a change of look-ahead is done. Default 0.35.
    pub look_ahead_half_life: f32,
    /// A target that moves more metres than this in one frame was teleported: the camera jumps along. Default 4.
    pub teleport: f32,
    /// Radius in metres of the ball that must fit where the camera is. Default 0.2; less than the target's own half width, or
    /// walls it touches would pull the camera in.
    pub ball: f32,
    /// Metres kept between the camera and the ground below it. Default 0.3.
    pub clearance: f32,
    /// What leaves lines this many metres to both sides of it free is narrow: it may stand between camera and target. Default 0.45.
    ///
    /// Large: walls come between. 0: posts pull the camera in.
    pub narrow: f32,
    /// Seconds in which half of the way out is made up once nothing is in the way. Default 0.25.
    ///
    /// Short: the picture pumps behind posts. Long: it stays close after a corner.
    pub ease_out_half_life: f32,
    /// Vertical field of view at rest, radians. Default 50°.
    pub field_of_view: f32,
    /// How much the field of view widens at [`Self::fast`], radians. Default 6°.
    pub widening: f32,
    /// Speed of the target in m/s at which the field of view is widest; it starts to widen at half of it. Default 6.
    pub fast: f32,
}

impl Default for OrbitCameraConfig {
    fn default() -> Self {
        Self {
            pivot_height: 1.45,
            shoulder: 0.35,
            follow_half_life: 0.05,
            climb_half_life: 0.16,
            orbit_half_life: 0.018,
            zoom_half_life: 0.09,
            nearest: 1.5,
            farthest: 12.0,
            zoom_step: 0.86,
            lowest_pitch: -35f32.to_radians(),
            highest_pitch: 75f32.to_radians(),
            look_ahead: 0.12,
            most_look_ahead: 0.8,
            look_ahead_half_life: 0.35,
            teleport: 4.0,
            ball: 0.2,
            clearance: 0.3,
            narrow: 0.45,
            ease_out_half_life: 0.25,
            field_of_view: 50f32.to_radians(),
            widening: 6f32.to_radians(),
            fast: 6.0,
        }
    }
}
