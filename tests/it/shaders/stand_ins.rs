//! What `shaders/character.wgsl` imports of the engine, in small: the same names, read from the test's own buffers.

/// How the test numbers what the vertex stage reads. Mirrors `Scene` and `Record` of `stage.rs`.
const BINDINGS: &str = "#define_import_path bevy_pbr::mesh_bindings
struct Scene {
    world_from_model: mat4x4<f32>,
    previous_world_from_model: mat4x4<f32>,
    vertex_count: u32,
    target_count: u32,
}
struct Record { first_vertex_index: u32, morph_descriptor_index: u32, tag: u32, flags: u32 }
struct Delta { position: vec4<f32>, normal: vec4<f32>, tangent: vec4<f32> }
@group(1) @binding(0) var<storage, read> scene: Scene;
@group(1) @binding(1) var<storage, read> mesh: array<Record>;
// By target, then by vertex.
@group(1) @binding(2) var<storage, read> deltas: array<Delta>;
// This frame's weight and the last frame's, by target.
@group(1) @binding(3) var<storage, read> weights: array<vec2<f32>>;
";

const MORPH: &str = "#define_import_path bevy_pbr::morph
#import bevy_pbr::mesh_bindings::{scene, deltas, weights}
fn layer_count(instance: u32) -> u32 { return scene.target_count; }
fn weight_at(layer: u32, instance: u32) -> f32 { return weights[layer].x; }
fn prev_weight_at(layer: u32, instance: u32) -> f32 { return weights[layer].y; }
fn morph_position(vertex: u32, layer: u32, instance: u32) -> vec3<f32> {
    return deltas[layer * scene.vertex_count + vertex].position.xyz;
}
fn morph_normal(vertex: u32, layer: u32, instance: u32) -> vec3<f32> {
    return deltas[layer * scene.vertex_count + vertex].normal.xyz;
}
fn morph_tangent(vertex: u32, layer: u32, instance: u32) -> vec3<f32> {
    return deltas[layer * scene.vertex_count + vertex].tangent.xyz;
}
";

const FUNCTIONS: &str = "#define_import_path bevy_pbr::mesh_functions
#import bevy_pbr::mesh_bindings::{mesh, scene}
fn get_tag(instance: u32) -> u32 { return mesh[instance].tag; }
fn get_world_from_local(instance: u32) -> mat4x4<f32> { return scene.world_from_model; }
fn get_previous_world_from_local(instance: u32) -> mat4x4<f32> { return scene.previous_world_from_model; }
fn mesh_position_local_to_world(world_from_model: mat4x4<f32>, position: vec4<f32>) -> vec4<f32> {
    return world_from_model * position;
}
fn sign_determinant_model_3x3m(flags: u32) -> f32 { return select(-1.0, 1.0, flags == 1u); }
";

/// Every vertex lands on the one pixel there is.
const VIEW: &str = "#define_import_path bevy_pbr::view_transformations
fn position_world_to_clip(position: vec3<f32>) -> vec4<f32> { return vec4(0.0, 0.0, 0.5, 1.0); }
";

/// Everything that a pass may ask for; `capture.wgsl` reads it.
const OUTPUT: &str = "
struct VertexOutput {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) world_normal: vec3<f32>,
    @location(2) world_tangent: vec4<f32>,
    @location(3) previous_world_position: vec4<f32>,
    @location(4) color: vec4<f32>,
    @location(5) @interpolate(flat) instance_index: u32,
}
";

/// All of them.
pub(super) fn modules() -> Vec<String> {
    let outputs = ["forward_io", "prepass_io"].map(|name| format!("#define_import_path bevy_pbr::{name}{OUTPUT}"));
    [BINDINGS, MORPH, FUNCTIONS, VIEW].into_iter().map(str::to_owned).chain(outputs).collect()
}

/// The fragment stage: writes what the vertex stage gave to the place of its instance. Mirrors `Moved` of `stage.rs`.
pub(super) const CAPTURE: &str = "
struct Moved { position: vec4<f32>, normal: vec4<f32>, tangent: vec4<f32>, previous: vec4<f32> }
@group(1) @binding(4) var<storage, read_write> moved: array<Moved>;
@fragment
fn capture(
    @location(0) position: vec4<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec4<f32>,
    @location(3) previous: vec4<f32>,
    @location(5) @interpolate(flat) instance: u32,
) -> @location(0) vec4<f32> {
    moved[instance] = Moved(position, vec4(normal, 0.0), tangent, previous);
    return vec4(1.0);
}
";
