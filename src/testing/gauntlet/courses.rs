//! Which tapes are played on which worlds. Pure data.

use core::f32::consts::TAU;

use bevy::prelude::*;

use crate::testing::{tape::Tape, world::World};

/// A tape on a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// The ground.
    pub world: World,
    /// What all walkers are told.
    pub tape: Tape,
    /// Where walkers start; several don't meet.
    pub starts: Vec<Transform>,
}

impl Course {
    fn new(world: &World, tape: Tape) -> Self {
        Self { world: world.clone(), tape, starts: vec![Transform::IDENTITY] }
    }

    /// Standing at `places`, put down on the ground.
    fn stands(world: &World, places: &[Transform]) -> Self {
        let starts = world.on_ground(places);
        let tape = Tape { name: format!("stand in {} places", starts.len()), ..Tape::stand() };
        Self { world: world.clone(), tape, starts }
    }
}

/// Every course, world by world.
#[must_use]
pub fn courses() -> Vec<Course> {
    let mut courses: Vec<Course> = flat().collect();
    for degrees in [10.0, 20.0, 30.0] {
        courses.extend(on(&World::ramp(degrees), [Tape::walk(), Tape::run()]));
        let slope = World::slope(degrees);
        courses.extend(on(&slope, [Tape::walk_back(), Tape::s_curve(), Tape::start_stop()]));
        courses.push(Course::stands(&slope, &scattered()));
    }
    courses.extend(on(&World::slope(20.0), [Tape::pivot(), Tape::strafe(), Tape::turning()]));
    for stairs in [World::stairs_up(12, 0.17, 0.29), World::stairs_down(12, 0.17, 0.29)] {
        courses.extend(on(&stairs, [Tape::walk(), Tape::run(), Tape::start_stop()]));
        courses.push(Course::stands(&stairs, &scattered()));
    }
    let rubble = World::rubble();
    courses.extend(on(&rubble, [Tape::walk(), Tape::run(), Tape::s_curve(), Tape::start_stop()]));
    courses.push(Course::stands(&rubble, &scattered()));
    let ridge = World::ridge();
    courses.extend(on(&ridge, [Tape::walk(), Tape::run()]));
    courses.push(Course::stands(&ridge, &in_file(0.02)));
    let stones = World::stepping_stones();
    courses.extend(on(&stones, [Tape::walk(), Tape::run(), Tape::start_stop()]));
    courses.push(Course::stands(&stones, &scattered()));
    let hills = World::hills();
    let tapes = [Tape::walk(), Tape::run(), Tape::change_gait(), Tape::s_curve(), Tape::pivot(), Tape::strafe()];
    courses.extend(on(&hills, tapes));
    courses.extend(on(&hills, [Tape::jump()]));
    courses.push(Course::stands(&hills, &scattered()));
    courses.extend(on(&World::curb(), [Tape::walk(), Tape::run(), Tape::start_stop()]));
    let platform = World::moving_platform();
    courses.extend(on(&platform, [Tape::stand(), Tape::walk(), Tape::start_stop(), Tape::jump()]));
    courses.extend(on(&World::rotating_platform(), [Tape::stand(), Tape::walk(), Tape::turning()]));
    let cliff = World::cliff();
    courses.extend(on(&cliff, [Tape::walk()]));
    courses.push(Course::stands(&cliff, &in_file(-0.02)));
    courses
}

/// Every tape on the plain.
fn flat() -> impl Iterator<Item = Course> {
    let tapes = [
        Tape::stand(),
        Tape::walk(),
        Tape::run(),
        Tape::change_gait(),
        Tape::s_curve(),
        Tape::pivot(),
        Tape::start_stop(),
        Tape::strafe(),
        Tape::jump(),
        Tape::turning(),
    ];
    on(&World::flat(), tapes)
}

fn on<const N: usize>(world: &World, tapes: [Tape; N]) -> impl Iterator<Item = Course> + use<N> {
    tapes.map(|tape| Course::new(world, tape)).into_iter()
}

/// Twelve places on stairs, slopes and in rubble, each facing another way.
fn scattered() -> Vec<Transform> {
    let place = |index: u8| {
        let (column, row) = (f32::from(index % 4), f32::from(index / 4));
        facing(index, Vec3::new(1.4 * column - 2.1, 0.0, -3.6 - 1.23 * row))
    };
    (0..12).map(place).collect()
}

/// Six places along the way, each `aside` metres further right than the one before, each facing another way.
fn in_file(aside: f32) -> Vec<Transform> {
    let place = |index: u8| facing(2 * index, Vec3::new(aside * f32::from(index), 0.0, -3.0 - 1.3 * f32::from(index)));
    (0..6).map(place).collect()
}

fn facing(twelfths: u8, place: Vec3) -> Transform {
    Transform::from_translation(place).with_rotation(Quat::from_rotation_y(f32::from(twelfths) * TAU / 12.0))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_course_has_a_name_of_its_own_and_someone_to_walk_it() {
        let courses = courses();
        let names: BTreeSet<_> = courses.iter().map(|course| (&course.world.name, &course.tape.name)).collect();
        assert_eq!(names.len(), courses.len(), "two rows of the table share a name");
        assert!(courses.iter().all(|course| !course.starts.is_empty()), "a course without walkers");
    }
}
