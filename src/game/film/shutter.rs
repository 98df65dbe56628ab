//! Takes pictures of an app that has no window: time stands still but for the steps that lead to a picture.

use bevy::{
    camera::RenderTarget,
    prelude::*,
    render::{
        render_resource::TextureFormat,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    time::TimeUpdateStrategy,
};
use image::RgbImage;

/// The picture that cameras draw into.
#[derive(Resource, Clone)]
pub struct Canvas(Handle<Image>);

impl Canvas {
    /// The picture itself.
    #[must_use]
    pub fn image(&self) -> &Handle<Image> {
        &self.0
    }

    /// What makes a camera draw into it.
    #[must_use]
    pub fn target(&self) -> RenderTarget {
        RenderTarget::Image(self.0.clone().into())
    }
}

/// Number of the picture that a screenshot will be.
#[derive(Component)]
struct Frame(usize);

/// Pictures back from the renderer.
#[derive(Resource, Default)]
struct Developed(Vec<(usize, RgbImage)>);

/// Gives an app of [`headless`](crate::game::engine::headless) a [`Canvas`], and stops its clock.
pub struct ShutterPlugin {
    /// Width and height of pictures, pixels.
    pub size: UVec2,
}

impl Plugin for ShutterPlugin {
    fn build(&self, app: &mut App) {
        let canvas = Image::new_target_texture(self.size.x, self.size.y, TextureFormat::Rgba8UnormSrgb, None);
        let canvas = app.world_mut().resource_mut::<Assets<Image>>().add(canvas);
        app.insert_resource(Canvas(canvas))
            .insert_resource(TimeUpdateStrategy::FixedTimesteps(0))
            .init_resource::<Developed>();
    }
}

/// Makes `ticks` fixed steps and takes picture number `frame` of the last. It is [`developed`] some updates later.
pub fn expose(app: &mut App, frame: usize, ticks: u32) {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    shutter(app, false);
    for _ in 1..ticks {
        app.update();
    }
    shutter(app, true);
    let canvas = app.world().resource::<Canvas>().0.clone();
    app.world_mut().spawn((Screenshot::image(canvas), Frame(frame))).observe(keep);
    app.update();
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
    shutter(app, false);
}

/// Takes the pictures that are ready, each with its number.
#[must_use]
pub fn developed(app: &mut App) -> Vec<(usize, RgbImage)> {
    std::mem::take(&mut app.world_mut().resource_mut::<Developed>().0)
}

/// Lets cameras draw, or not: steps between two pictures need none.
fn shutter(app: &mut App, open: bool) {
    let mut cameras = app.world_mut().query::<&mut Camera>();
    for mut camera in cameras.iter_mut(app.world_mut()) {
        camera.is_active = open;
    }
}

fn keep(picture: On<ScreenshotCaptured>, frames: Query<&Frame>, mut developed: ResMut<Developed>) {
    let Ok(frame) = frames.get(picture.entity) else { return };
    match picture.image.clone().try_into_dynamic() {
        Ok(image) => developed.0.push((frame.0, image.to_rgb8())),
        Err(error) => error!("picture {} has no usable format: {error}", frame.0),
    }
}
