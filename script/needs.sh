# Sourced by script/play and script/test: finds what the machine lacks and installs it, or says what to install.
#
# need_build, need_run, need_window and need_tests add Debian package names to `missing`, each after a look for the thing itself,
# so that a machine that has all (from whatever source) needs no network. Only Linux needs anything beyond Rust.

missing=()

on_linux() { [ "$(uname -s)" = Linux ]; }

# have_library NAME: the dynamic loader can find it.
have_library() {
    local loader=ldconfig
    command -v ldconfig >/dev/null || loader=/sbin/ldconfig
    # No pipe into `grep -q`: it would end the writer early, which `pipefail` counts as a failure.
    grep -qF "$1" <<<"$("$loader" -p 2>/dev/null)" && return
    local folder
    for folder in ${LD_LIBRARY_PATH:+${LD_LIBRARY_PATH//:/ }} /lib /usr/lib /lib64 /usr/lib64; do
        [ -e "$folder/$1" ] && return
    done
    return 1
}

# have_vulkan_driver: some driver is registered with the Vulkan loader.
have_vulkan_driver() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return
    local data="${XDG_DATA_HOME:-$HOME/.local/share}"
    compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null || compgen -G '/usr/local/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null || compgen -G "$data/vulkan/icd.d/*.json" >/dev/null
}

need() { missing+=("$1"); }
need_library() { have_library "$1" || need "$2"; }
need_command() { command -v "$1" >/dev/null || need "$2"; }

# What the compiler needs: a linker, C++ for the library that simplifies meshes, and udev for gamepads.
need_build() {
    if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then
        PATH="$HOME/.cargo/bin:$PATH"
    fi
    if ! command -v cargo >/dev/null; then
        echo "cargo is missing. Install Rust 1.95 or newer: https://rustup.rs" >&2
        exit 1
    fi
    on_linux || return 0
    need_command cc gcc
    need_command c++ g++
    # gcc alone, without the headers of libc, can't link.
    [ -e /usr/include/stdlib.h ] || need libc6-dev
    need_command pkg-config pkg-config
    if ! command -v pkg-config >/dev/null || ! pkg-config --exists libudev; then
        need libudev-dev
    fi
}

# What drawing needs: the Vulkan loader and a driver, by software if there is no GPU.
need_run() {
    on_linux || return 0
    need_library libvulkan.so.1 libvulkan1
    have_vulkan_driver || need mesa-vulkan-drivers
}

# What a window on X11 needs at run time.
need_window() {
    on_linux || return 0
    need_library libX11.so.6 libx11-6
    need_library libX11-xcb.so.1 libx11-xcb1
    need_library libXcursor.so.1 libxcursor1
    need_library libXi.so.6 libxi6
    need_library libXrandr.so.2 libxrandr2
    need_library libXrender.so.1 libxrender1
    need_library libxkbcommon.so.0 libxkbcommon0
    need_library libxkbcommon-x11.so.0 libxkbcommon-x11-0
}

# What the window test needs: a display without a screen, and keys pressed by a program.
need_tests() {
    on_linux || return 0
    need_command Xvfb xvfb
    need_command xdotool xdotool
}

# Installs `missing` through apt when that is allowed without a question, else says how and exits 1.
install_missing() {
    [ ${#missing[@]} -eq 0 ] && return
    local install="apt-get install -y --no-install-recommends ${missing[*]}"
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        as_root=(sudo -n)
    fi
    if ! command -v apt-get >/dev/null; then
        echo "Missing, by their Debian names: ${missing[*]}. Install them with your package manager." >&2
        exit 1
    fi
    if [ ${#as_root[@]} -gt 0 ] && ! sudo -n true 2>/dev/null; then
        echo "Missing: ${missing[*]}. Install with: sudo $install" >&2
        exit 1
    fi
    echo "Installing: ${missing[*]}"
    export DEBIAN_FRONTEND=noninteractive
    "${as_root[@]}" apt-get update || echo "apt-get update failed; trying with the lists at hand" >&2
    # shellcheck disable=SC2086 # words of a command, split on purpose
    if ! "${as_root[@]}" $install; then
        echo "Could not install. Run by hand: sudo apt-get update && sudo $install" >&2
        exit 1
    fi
}

# One build folder outside of the source tree, shared by all scripts.
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/surefoot/target}"
# Mesa complains without one.
if on_linux && [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    XDG_RUNTIME_DIR="${TMPDIR:-/tmp}/surefoot-runtime-$(id -u)"
    mkdir -p -m 700 "$XDG_RUNTIME_DIR"
    export XDG_RUNTIME_DIR
fi
