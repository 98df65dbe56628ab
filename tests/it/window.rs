//! The real game in a real window on a virtual display, steered by real key presses.

use std::{
    f32::consts::TAU,
    fs,
    io::{BufRead, BufReader},
    path::PathBuf,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use bevy::math::ops;

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
            .args(["-displayfd", "1", "-screen", "0", "640x360x24", "-nolisten", "tcp", "-noreset"])
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
#[derive(Clone, Debug, Default)]
struct Moment {
    position: [f32; 3],
    camera: [f32; 3],
    heading: f32,
    state: String,
    grounded: bool,
    crouched: bool,
    help: bool,
    feet: bool,
}

/// Reads one line of telemetry; `None` for a line that is half written.
fn moment(line: &str) -> Option<Moment> {
    let line: serde_json::Value = serde_json::from_str(line).ok()?;
    let number = |value: &serde_json::Value| value.as_f64().map(|number| number as f32);
    let vector = |name: &str| {
        let numbers = line.get(name)?.as_array()?;
        Some([number(&numbers[0])?, number(&numbers[1])?, number(&numbers[2])?])
    };
    let is = |name: &str| line.get(name).and_then(serde_json::Value::as_bool);
    Some(Moment {
        position: vector("position")?,
        camera: vector("camera")?,
        heading: number(line.get("heading")?)?,
        state: line.get("state")?.as_str()?.to_owned(),
        grounded: is("grounded")?,
        crouched: is("crouched")?,
        help: is("help")?,
        feet: is("feet")?,
    })
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

fn level_distance(from: &Moment, to: &Moment) -> f32 {
    (from.position[0] - to.position[0]).hypot(from.position[2] - to.position[2])
}

/// From where the camera sees the hero: radians about +Y, and metres.
fn view(moment: &Moment) -> (f32, f32) {
    let [x, y, z] = [0, 1, 2].map(|axis| moment.camera[axis] - moment.position[axis]);
    (ops::atan2(x, z), (x * x + y * y + z * z).sqrt())
}

/// Radians from one heading to another, 0 to π.
fn turn(from: f32, to: f32) -> f32 {
    let turn = (to - from).rem_euclid(TAU);
    turn.min(TAU - turn)
}

/// The game on a display of its own, its hero on its feet.
struct Session {
    _server: Running,
    display: String,
    game: Running,
    telemetry: PathBuf,
}

impl Session {
    fn start(name: &str) -> Self {
        let (server, display) = display();
        let telemetry = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name).with_extension("jsonl");
        let _ = fs::remove_file(&telemetry);
        let game = start(
            Command::new(env!("CARGO_BIN_EXE_surefoot"))
                .args(["--size", "320x180", "--telemetry"])
                .arg(&telemetry)
                .env("DISPLAY", &display)
                .env_remove("WAYLAND_DISPLAY"),
            "",
        );
        let mut session = Self { _server: server, display, game, telemetry };
        let display = session.display.clone();
        let window = wait_for("window", START, &mut session.game, || {
            Some(xdotool(&display, &["search", "--name", "^Surefoot$"])).filter(|found| !found.is_empty())
        });
        session.press(&["windowfocus", "--sync", &window]);
        session.wait_until("hero on the ground", START, |moment| moment.grounded && moment.state == "idle");
        session
    }

    /// Does something with keys or the mouse.
    fn press(&self, arguments: &[&str]) {
        xdotool(&self.display, arguments);
    }

    fn now(&self) -> Moment {
        last_moment(&self.telemetry).unwrap()
    }

    /// Waits for a moment that is as wanted.
    fn wait_until(&mut self, what: &str, patience: Duration, is: impl Fn(&Moment) -> bool) -> Moment {
        let telemetry = self.telemetry.clone();
        wait_for(what, patience, &mut self.game, || last_moment(&telemetry).filter(&is))
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.telemetry);
    }
}

#[test]
fn a_key_pressed_in_the_window_walks_the_hero() {
    let mut session = Session::start("keys");
    let standing = session.now();
    std::thread::sleep(Duration::from_secs(1));
    let untouched = session.now();
    let drift = level_distance(&standing, &untouched);
    assert!(drift < 0.05, "walked {drift:.2} m without a key");

    session.press(&["keydown", "w"]);
    let walking =
        session.wait_until("step of a metre while W is held", WALK, |now| level_distance(&untouched, now) > 1.0);
    session.press(&["keyup", "w"]);
    let walked = level_distance(&untouched, &walking);
    assert!(walked < 50.0, "a key of a few seconds threw the hero {walked:.1} m");
    let stopped = session.wait_until("rest after W was released", WALK, |now| now.state == "idle");
    assert!(stopped.grounded, "left in the air at {:?}", stopped.position);

    session.press(&["key", "space"]);
    session.wait_until("jump after a tap of Space", WALK, |now| now.position[1] > stopped.position[1] + 0.2);
    session.wait_until("landing", WALK, |now| now.grounded);
    session.press(&["keydown", "c"]);
    session.wait_until("crouch while C is held", WALK, |now| now.crouched);
    session.press(&["keyup", "c"]);
    session.wait_until("rise after C was released", WALK, |now| !now.crouched);
    assert!(session.now().help, "no line of controls at first");
    session.press(&["key", "F1"]);
    session.wait_until("hidden line of controls after F1", WALK, |now| !now.help);
    session.press(&["key", "F3"]);
    session.wait_until("view of the feet after F3", WALK, |now| now.feet);
}

#[test]
fn the_mouse_turns_the_view_zooms_and_aims() {
    let mut session = Session::start("mouse");
    let (yaw, distance) = view(&session.now());
    session.press(&["mousemove", "160", "90", "click", "4", "click", "4", "click", "4"]);
    session.wait_until("camera nearer after three steps of the wheel", WALK, |now| view(now).1 < distance - 0.8);

    session.press(&["click", "1"]);
    std::thread::sleep(Duration::from_secs(2));
    for _ in 0..8 {
        session.press(&["mousemove_relative", "--", "50", "0"]);
        std::thread::sleep(Duration::from_millis(100));
    }
    let turned = session.wait_until("turned view", WALK, |now| turn(yaw, view(now).0) > 0.5);
    assert!(turn(turned.heading, session.now().heading) < 0.1, "the view turned the hero too");

    session.press(&["mousedown", "3"]);
    session.wait_until("hero that faces where the camera looks while the right button is held", WALK, |now| {
        // The camera is behind who looks where it looks.
        turn(now.heading, view(now).0) < 0.3 && turn(now.heading, turned.heading) > 0.4
    });
    session.press(&["mouseup", "3", "key", "Escape"]);
}
