//! Is there a driver that can draw?

use bevy::tasks::block_on;

use super::Missing;

#[cfg(target_os = "linux")]
const MEND: &str = "Install one: sudo apt-get install -y libvulkan1 mesa-vulkan-drivers";
#[cfg(not(target_os = "linux"))]
const MEND: &str = "Update the driver of your graphics card";

/// Environment variables that tell the Vulkan loader to look at certain drivers only.
const LOADER_VARIABLES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Finds out if any graphics driver answers, a software one included.
///
/// # Errors
/// [`Missing::Driver`] if none does.
pub fn check() -> Result<(), Missing> {
    let backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    if !block_on(instance.enumerate_adapters(backends)).is_empty() {
        return Ok(());
    }
    let set = LOADER_VARIABLES.iter().find_map(|name| Some((name, std::env::var(name).ok()?)));
    let detail = set.map_or_else(String::new, |(name, value)| format!(" ({name} is set to {value})"));
    Err(Missing::Driver { detail, mend: MEND })
}
