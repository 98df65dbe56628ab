// Vertex stage of `SkinnedMaterial` (src/skinning/material.rs) for the main, prepass, deferred and shadow passes:
// morph targets, then the skin, then the entity's transform.
#import bevy_pbr::{mesh_functions, view_transformations::position_world_to_clip}
#import surefoot::skinning
#import bevy_pbr::mesh_bindings::mesh
#ifdef MORPH_TARGETS
#import bevy_pbr::morph
#endif
#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::VertexOutput
#else
#import bevy_pbr::forward_io::VertexOutput
#endif

// The engine gives attributes other locations in the prepass. VERTEX_COLORS is always on, since the tint is a vertex
// colour; MESH_COLORS says that the mesh has its own as well.
struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
#ifdef PREPASS_PIPELINE
#ifdef VERTEX_UVS_A
    @location(1) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(2) uv_b: vec2<f32>,
#endif
#ifdef VERTEX_NORMALS
    @location(3) normal: vec3<f32>,
#endif
#ifdef VERTEX_TANGENTS
    @location(4) tangent: vec4<f32>,
#endif
#ifdef MESH_COLORS
    @location(7) color: vec4<f32>,
#endif
#else // PREPASS_PIPELINE
#ifdef VERTEX_NORMALS
    @location(1) normal: vec3<f32>,
#endif
#ifdef VERTEX_UVS_A
    @location(2) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(3) uv_b: vec2<f32>,
#endif
#ifdef VERTEX_TANGENTS
    @location(4) tangent: vec4<f32>,
#endif
#ifdef MESH_COLORS
    @location(5) color: vec4<f32>,
#endif
#endif // PREPASS_PIPELINE
#ifdef SUREFOOT_SKIN
    @location(10) slots: vec4<u32>,
    @location(11) weights: vec4<f32>,
#endif
#ifdef MORPH_TARGETS
    @builtin(vertex_index) index: u32,
#endif
}

#ifdef MORPH_TARGETS
// How many morph targets move this instance: none in the frame before the engine has placed their weights.
fn morph_count(instance: u32) -> u32 {
#ifndef SKINS_USE_UNIFORM_BUFFERS
    if mesh[instance].morph_descriptor_index == 0xffffffffu {
        return 0u;
    }
#endif
    return morph::layer_count(instance);
}
#endif

@vertex
fn vertex(v: Vertex) -> VertexOutput {
    var out: VertexOutput;
    let instance = v.instance_index;
    var position = v.position;
#ifdef VERTEX_NORMALS
    var normal = v.normal;
#endif
#ifdef VERTEX_TANGENTS
    var tangent = v.tangent;
#endif

#ifdef MOTION_VECTOR_PREPASS
    var previous_position = v.position;
#endif
#ifdef MORPH_TARGETS
    let index = v.index - mesh[instance].first_vertex_index;
    let count = morph_count(instance);
    for (var layer = 0u; layer < count; layer++) {
        let weight = morph::weight_at(layer, instance);
#ifdef MOTION_VECTOR_PREPASS
#ifdef HAS_PREVIOUS_MORPH
        let previous_weight = morph::prev_weight_at(layer, instance);
#else
        let previous_weight = weight;
#endif
        let rests = weight == 0.0 && previous_weight == 0.0;
#else
        let rests = weight == 0.0;
#endif
        if rests {
            continue;
        }
        let offset = morph::morph_position(index, layer, instance);
        position += weight * offset;
#ifdef VERTEX_NORMALS
        normal += weight * morph::morph_normal(index, layer, instance);
#endif
#ifdef VERTEX_TANGENTS
        tangent += vec4<f32>(weight * morph::morph_tangent(index, layer, instance), 0.0);
#endif
#ifdef MOTION_VECTOR_PREPASS
        previous_position += previous_weight * offset;
#endif
    }
#endif // MORPH_TARGETS

    // A mesh without weights rides on its palette's first matrix.
#ifdef SUREFOOT_SKIN
    let slots = v.slots;
    let weights = v.weights;
#else
    let slots = vec4<u32>(0u);
    let weights = vec4<f32>(1.0, 0.0, 0.0, 0.0);
#endif
    let tag = mesh_functions::get_tag(instance);
    let model_from_mesh = skinning::skin_matrix(tag, slots, weights);
    let world_from_model = mesh_functions::get_world_from_local(instance);
    let world_from_mesh = skinning::placed(world_from_model, model_from_mesh);
#ifdef MOTION_VECTOR_PREPASS
    previous_position = skinning::skin_point(skinning::previous_skin_matrix(tag, slots, weights), previous_position);
#endif

    out.world_position = vec4<f32>(skinning::skin_point(world_from_mesh, position), 1.0);
    out.position = position_world_to_clip(out.world_position.xyz);
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.unclipped_depth = out.position.z;
    out.position.z = min(out.position.z, 1.0);
#endif
#ifdef VERTEX_NORMALS
    out.world_normal = skinning::skin_normal(world_from_mesh, normal);
#endif
#ifdef VERTEX_TANGENTS
    let handedness = tangent.w * mesh_functions::sign_determinant_model_3x3m(mesh[instance].flags);
    out.world_tangent = vec4<f32>(skinning::skin_tangent(world_from_mesh, tangent.xyz), handedness);
#endif
#ifdef VERTEX_UVS_A
    out.uv = v.uv;
#endif
#ifdef VERTEX_UVS_B
    out.uv_b = v.uv_b;
#endif
#ifdef VERTEX_COLORS
    out.color = skinning::instance_tint(tag);
#ifdef MESH_COLORS
    out.color *= v.color;
#endif
#endif
#ifdef PREPASS_PIPELINE
#ifdef MOTION_VECTOR_PREPASS
    out.previous_world_position = mesh_functions::mesh_position_local_to_world(
        mesh_functions::get_previous_world_from_local(instance), vec4<f32>(previous_position, 1.0));
#endif
#endif
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    out.instance_index = instance;
#endif
#ifdef VISIBILITY_RANGE_DITHER
    out.visibility_range_dither = mesh_functions::get_visibility_range_dither_level(instance, world_from_model[3]);
#endif
    return out;
}
