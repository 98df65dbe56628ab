//! Characters come, grow, move and go: what is drawn, and what it costs.

use bevy::{math::Affine3A, mesh::MeshTag, prelude::*};
use surefoot::skinning::{Palette, SkinArena, SkinUpload, SkinningPlugin, Tint};

use super::{JOINTS, Stock, pose, test_tube};
use crate::{
    render_support::{DrawSets, Studio, headless_plugins},
    tube::tube_palette,
};

#[test]
fn a_tint_colours_one_character_alone() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let owner = stock.spawn(&mut studio, Transform::default());
    let plain = studio.picture().mean_drawn();
    studio.world().entity_mut(owner).insert(Tint(LinearRgba::rgb(0.1, 1.0, 1.0)));
    let tinted = studio.picture().mean_drawn();
    assert!(tinted[0] < 0.6 * plain[0], "red went from {} to {}", plain[0], tinted[0]);
    assert!((tinted[1] - plain[1]).abs() < 2.0, "green went from {} to {}", plain[1], tinted[1]);
    let other = stock.spawn(&mut studio, Transform::default());
    studio.world().despawn(owner);
    assert_eq!(studio.world().get::<MeshTag>(other), Some(&MeshTag(2)), "records stay where they are");
    let other = studio.picture().mean_drawn();
    assert!((other[0] - plain[0]).abs() < 0.01, "red of another is {} not {}", other[0], plain[0]);
    assert_eq!(studio.draw_sets().opaque, 1);
}

/// Rows of tubes, each in its own pose.
fn crowd(studio: &mut Studio, stock: &Stock, count: usize) -> Vec<Entity> {
    (0..count)
        .map(|i| {
            let (row, column) = (i / 10, i % 10);
            let place = Transform::from_xyz(column as f32 * 0.7 - 3.1, 0.0, -(row as f32))
                .with_rotation(Quat::from_rotation_y(i as f32))
                .with_scale(Vec3::splat(0.5));
            let owner = stock.spawn(studio, place);
            pose(studio, owner, &tube_palette(JOINTS, 0.6, i as f32));
            owner
        })
        .collect()
}

#[test]
fn any_number_of_characters_is_one_draw() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let few = crowd(&mut studio, &stock, 3);
    studio.picture();
    assert_eq!(studio.draw_sets(), DrawSets { opaque: 1, shadow: 1 }, "three characters");
    for owner in few {
        studio.world().despawn(owner);
    }
    crowd(&mut studio, &stock, 100);
    studio.picture().save("crowd");
    assert_eq!(studio.draw_sets(), DrawSets { opaque: 1, shadow: 1 }, "a hundred characters");
}

#[test]
fn growing_while_running_changes_no_pixel() {
    let mut roomy = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut roomy, &test_tube());
    crowd(&mut roomy, &stock, 40);
    let wanted = roomy.picture();

    let mut tight = Studio::new(SkinningPlugin { initial_joints: 20 });
    let stock = Stock::new(&mut tight, &test_tube());
    let early = crowd(&mut tight, &stock, 2);
    tight.picture();
    for owner in early {
        tight.world().despawn(owner);
    }
    crowd(&mut tight, &stock, 40);
    let frame = tight.step();
    assert!(tight.last_upload().buffers_made >= 2, "{:?}", tight.last_upload());
    let difference = tight.frame(frame).difference(&wanted, 0);
    assert_eq!(difference.beyond, 0, "in the very frame of the growth: {difference:?}");
}

#[test]
fn a_despawn_leaves_the_others_as_they_were() {
    let mut studio = Studio::new(SkinningPlugin { initial_joints: 64 });
    let stock = Stock::new(&mut studio, &test_tube());
    let stays = stock.spawn(&mut studio, Transform::from_xyz(0.8, 0.0, 0.0));
    pose(&mut studio, stays, &tube_palette(JOINTS, 1.0, 0.4));
    let wanted = studio.picture();
    for round in 0..6 {
        // Outside the picture, so that only a mix-up of palettes shows.
        let guests: Vec<_> =
            (0..=round).map(|_| stock.spawn(&mut studio, Transform::from_xyz(0.0, 0.0, 50.0))).collect();
        for guest in &guests {
            pose(&mut studio, *guest, &[Affine3A::from_translation(Vec3::splat(0.5)); JOINTS]);
        }
        let with_guests = studio.step();
        for guest in guests {
            studio.world().despawn(guest);
        }
        let without = studio.step();
        for frame in [with_guests, without] {
            let difference = studio.frame(frame).difference(&wanted, 0);
            assert_eq!(difference.beyond, 0, "round {round}, frame {frame}: {difference:?}");
        }
    }
    let arena = studio.world().resource::<SkinArena>();
    assert_eq!(arena.all_matrices().len(), 1 + JOINTS, "what guests had came back");
}

#[test]
fn nothing_is_uploaded_while_nothing_moves() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let owner = stock.spawn(&mut studio, Transform::default());
    studio.picture();
    studio.step();
    assert_eq!(studio.last_upload().bytes, 0);
    pose(&mut studio, owner, &tube_palette(JOINTS, 0.5, 0.0));
    studio.step();
    let moved = studio.last_upload();
    assert_eq!(moved.bytes, 48 * JOINTS as u64 + 16, "its matrices, once, and the header");
    studio.step();
    assert_eq!(studio.last_upload().bytes, 16, "the header says that the last frame was the same");
    studio.step();
    assert_eq!((studio.last_upload().bytes, studio.last_upload().buffers_made), (0, 1));
}

#[test]
fn who_moves_is_uploaded_and_nothing_is_made_anew() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    let owners = crowd(&mut studio, &stock, 100);
    studio.picture();
    let before = studio.last_upload();
    for moment in 0..5u8 {
        pose(&mut studio, owners[70], &tube_palette(JOINTS, 0.1 * f32::from(moment), 0.0));
        studio.step();
        if moment == 0 {
            // The other half of the buffer still lacks how the crowd came.
            continue;
        }
        let one = studio.last_upload();
        assert_eq!((one.bytes, one.writes), (48 * JOINTS as u64 + 16, 2), "one of a hundred moves");
    }
    for owner in &owners {
        pose(&mut studio, *owner, &tube_palette(JOINTS, 0.7, 0.0));
    }
    studio.step();
    let all = studio.last_upload();
    assert_eq!((all.bytes, all.writes), (100 * 48 * JOINTS as u64 + 16, 2), "all move: one write, and the header");
    let made = |upload: &SkinUpload| (upload.buffers_made, upload.bind_groups_made);
    assert_eq!(made(&all), made(&before), "buffers and bind groups in the steady state");
}

#[test]
fn culling_follows_the_pose_and_not_the_bind_pose() {
    let mut studio = Studio::new(SkinningPlugin::default());
    let stock = Stock::new(&mut studio, &test_tube());
    // The palette carries the tube ten metres from where it was skinned: to where the camera looks.
    let owner = stock.spawn(&mut studio, Transform::default());
    pose(&mut studio, owner, &[Affine3A::from_translation(Vec3::X * 10.0); JOINTS]);
    studio.look(Vec3::new(10.0, 1.0, 4.0), Vec3::new(10.0, 1.0, 0.0));
    assert!(studio.picture().drawn() > 1_000, "drawn where the pose is");
    let mesh = studio.world().get::<Children>(owner).expect("it has a mesh")[0];
    let seen = |studio: &mut Studio| studio.world().get::<ViewVisibility>(mesh).expect("meshes have it").get();
    assert!(seen(&mut studio));
    studio.look(Vec3::new(30.0, 1.0, 4.0), Vec3::new(30.0, 1.0, 0.0));
    let mut suns = studio.world().query_filtered::<Entity, With<DirectionalLight>>();
    let sun = suns.single(studio.app.world()).expect("the studio has one sun");
    studio.world().despawn(sun);
    studio.step();
    assert!(!seen(&mut studio), "culled where nothing of it is");
}

/// What must hold of an app that draws nothing.
fn palettes_live_in(mut app: App) {
    app.finish();
    app.cleanup();
    let owner = app.world_mut().spawn(Palette::new(4)).id();
    app.update();
    let range = app.world().get::<Palette>(owner).expect("just spawned").range();
    assert_eq!(app.world_mut().resource_mut::<SkinArena>().matrices_mut(range).len(), 4);
    app.update();
    app.world_mut().despawn(owner);
    app.update();
    assert_eq!(app.world().resource::<SkinArena>().all_matrices().len(), 1);
}

#[test]
fn without_rendering_palettes_live_and_nothing_is_drawn() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SkinningPlugin::default()));
    palettes_live_in(app);
}

#[test]
fn without_a_gpu_palettes_live_and_nothing_is_drawn() {
    let mut app = App::new();
    app.add_plugins((headless_plugins(None), SkinningPlugin::default()));
    palettes_live_in(app);
}
