//! Is there a display, does it answer, and what is missing if the window can't be made?

#[cfg(target_os = "linux")]
use std::{env, path::Path};

use super::Missing;

/// Whether the session has a display to open a window on. Systems other than Linux always have one.
#[must_use]
pub fn exists() -> bool {
    #[cfg(target_os = "linux")]
    return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
    #[cfg(not(target_os = "linux"))]
    true
}

/// Finds out if the display answers.
///
/// # Errors
/// [`Missing::Server`] or [`Missing::Xwayland`] if it does not.
#[cfg(target_os = "linux")]
pub fn check() -> Result<(), Missing> {
    if !is_set("DISPLAY") {
        return Err(Missing::Xwayland);
    }
    let connect = || x11rb::connect(None).map(|_| ());
    // A server without any window yet starts anew whenever its last program leaves, and is away for a moment.
    let answer = connect().or_else(|_| {
        std::thread::sleep(PATIENCE);
        connect()
    });
    answer.map_err(|error| Missing::Server {
        display: env::var("DISPLAY").unwrap_or_default(),
        reason: one_line(&error.to_string()),
    })
}

/// Wait before an X server is asked once more.
#[cfg(target_os = "linux")]
const PATIENCE: std::time::Duration = std::time::Duration::from_millis(500);

/// Finds out if the display answers; here it always does.
///
/// # Errors
/// None.
#[cfg(not(target_os = "linux"))]
pub fn check() -> Result<(), Missing> {
    Ok(())
}

/// Explains why the window library gave up with `reason`: names the packages of the libraries that are not there.
#[must_use]
pub fn explain(reason: &str) -> Missing {
    Missing::Window { reason: one_line(reason), mend: mend() }
}

#[cfg(target_os = "linux")]
fn mend() -> String {
    /// What the window library opens at run time, and the Debian packages that hold it.
    const LIBRARIES: &[(&str, &str)] = &[
        ("libX11.so.6", "libx11-6"),
        ("libX11-xcb.so.1", "libx11-xcb1"),
        ("libXcursor.so.1", "libxcursor1"),
        ("libXi.so.6", "libxi6"),
        ("libXrandr.so.2", "libxrandr2"),
        ("libXrender.so.1", "libxrender1"),
        ("libxkbcommon.so.0", "libxkbcommon0"),
        ("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
    ];
    let packages: Vec<_> =
        LIBRARIES.iter().filter(|(file, _)| !library_exists(file)).map(|(_, package)| *package).collect();
    if packages.is_empty() {
        return "All libraries it needs are there; `surefoot film` works without a window".to_owned();
    }
    format!("Install what it needs: sudo apt-get install -y {}", packages.join(" "))
}

#[cfg(not(target_os = "linux"))]
fn mend() -> String {
    "`surefoot film` works without a window".to_owned()
}

/// Whether one of the loader's usual folders holds `file`. Only for advice: other folders are possible.
#[cfg(target_os = "linux")]
fn library_exists(file: &str) -> bool {
    let triple = format!("{}-linux-gnu", env::consts::ARCH);
    let named = env::var("LD_LIBRARY_PATH").unwrap_or_default();
    let usual = ["/lib", "/usr/lib", "/lib64", "/usr/lib64", "/usr/local/lib"];
    named
        .split(':')
        .filter(|folder| !folder.is_empty())
        .chain(usual)
        .any(|folder| Path::new(folder).join(file).exists() || Path::new(folder).join(&triple).join(file).exists())
}

#[cfg(target_os = "linux")]
fn is_set(name: &str) -> bool {
    env::var_os(name).is_some_and(|value| !value.is_empty())
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_explanation_is_one_line_whatever_the_library_said() {
        let line = explain("Failed to build\n  event loop:\tOs(..)").to_string();
        assert!(!line.contains('\n'), "more than one line: {line}");
        assert!(line.contains("Failed to build event loop: Os(..)"), "reason lost: {line}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_c_library_is_found_and_an_invented_one_is_not() {
        assert!(library_exists("libc.so.6"), "libc.so.6 was not found");
        assert!(!library_exists("libsurefoot-invented.so.9"), "an invented library was found");
    }
}
