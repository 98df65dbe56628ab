//! The real game in a real window on a virtual display, steered by real key presses.

use std::{
    fs,
    io::{BufRead, BufReader},
    path::PathBuf,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

/// Seconds within which the window must be there and the hero on its feet; software drawing on two busy cores is slow.
const START: Duration = Duration::from_secs(120);
/// Seconds within which a held key must have moved the hero.
const WALK: Duration = Duration::from_secs(60);

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(command: &mut Command, package: &str) -> Running {
    Running(command.spawn().unwrap_or_else(|error| {
        panic!(
            "{} does not start: {error}. Install it: sudo apt-get install -y {package}",
            command.get_program().display()
        )
    }))
}

/// An X server on a free display, which it chooses itself.
fn display() -> (Running, String) {
    let mut server = start(
        Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "640x360x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null()),
        "xvfb",
    );
    let mut number = String::new();
    BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
    assert!(!number.trim().is_empty(), "Xvfb found no free display");
    (server, format!(":{}", number.trim()))
}

fn xdotool(display: &str, arguments: &[&str]) -> String {
    let output =
        Command::new("xdotool").args(arguments).env("DISPLAY", display).output().unwrap_or_else(|error| {
            panic!("xdotool does not start: {error}. Install it: sudo apt-get install -y xdotool")
        });
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// What the telemetry says of one moment.
#[derive(Clone, Copy, Debug)]
struct Moment {
    position: [f32; 3],
    grounded: bool,
}

/// Reads one line of telemetry; `None` for a line that is half written.
fn moment(line: &str) -> Option<Moment> {
    let numbers = line.split_once(r#""position": ["#)?.1.split_once(']')?.0;
    let mut numbers = numbers.split(',').map(|number| number.trim().parse::<f32>());
    let position = [numbers.next()?.ok()?, numbers.next()?.ok()?, numbers.next()?.ok()?];
    Some(Moment { position, grounded: line.contains(r#""grounded": true"#) })
}

fn last_moment(file: &PathBuf) -> Option<Moment> {
    fs::read_to_string(file).ok()?.lines().rev().find_map(moment)
}

/// Asks again until there is an answer.
fn wait_for<T>(what: &str, patience: Duration, game: &mut Running, mut ask: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        if let Some(status) = game.0.try_wait().unwrap() {
            panic!("the game ended with {status} while waiting for {what}");
        }
        assert!(began.elapsed() < patience, "no {what} within {} s", patience.as_secs());
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn level_distance(from: Moment, to: Moment) -> f32 {
    (from.position[0] - to.position[0]).hypot(from.position[2] - to.position[2])
}

#[test]
fn a_key_pressed_in_the_window_walks_the_hero() {
    let (_server, display) = display();
    let telemetry = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window.jsonl");
    let _ = fs::remove_file(&telemetry);
    let mut game = start(
        Command::new(env!("CARGO_BIN_EXE_surefoot"))
            .args(["--size", "320x180", "--telemetry"])
            .arg(&telemetry)
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY"),
        "",
    );

    let window = wait_for("window", START, &mut game, || {
        Some(xdotool(&display, &["search", "--name", "^Surefoot$"])).filter(|found| !found.is_empty())
    });
    xdotool(&display, &["windowfocus", "--sync", &window]);
    let standing =
        wait_for("hero on the ground", START, &mut game, || last_moment(&telemetry).filter(|moment| moment.grounded));
    std::thread::sleep(Duration::from_secs(1));
    let untouched = last_moment(&telemetry).unwrap();
    let drift = level_distance(standing, untouched);
    assert!(drift < 0.05, "walked {drift:.2} m without a key");

    xdotool(&display, &["keydown", "w"]);
    let walked = wait_for("step of a metre while W is held", WALK, &mut game, || {
        last_moment(&telemetry).map(|moment| level_distance(untouched, moment)).filter(|way| *way > 1.0)
    });
    xdotool(&display, &["keyup", "w"]);
    assert!(walked < 50.0, "a key of a few seconds threw the hero {walked:.1} m");

    let stopped = wait_for("rest after W was released", WALK, &mut game, || {
        let before = last_moment(&telemetry)?;
        std::thread::sleep(Duration::from_millis(700));
        last_moment(&telemetry).filter(|moment| level_distance(before, *moment) < 0.02)
    });
    assert!(stopped.grounded, "left in the air at {:?}", stopped.position);
    let _ = fs::remove_file(&telemetry);
}
