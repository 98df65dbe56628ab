// Sun, sky and haze on rough matter; `SkyLight` mirrors the one in src/terrain/sky.rs. Leaner than the engine's lighting, which
// also knows gloss and other lamps: where the processor draws, both sides of each of its branches run for every pixel.
#define_import_path surefoot::light
#import bevy_pbr::{
    mesh_view_bindings::{lights, view},
    shadow_sampling::sample_shadow_map,
    shadows::{get_cascade_index, world_to_directional_light_local},
}
#ifdef DISTANCE_FOG
#import bevy_pbr::{fog::exponential_squared_fog, mesh_view_bindings::fog}
#endif
#ifdef TONEMAP_IN_SHADER
#import bevy_core_pipeline::tonemapping::tone_mapping
#endif

struct SkyLight {
    above: vec4<f32>,
    around: vec4<f32>,
    below: vec4<f32>,
}

// How much of a light gets past what casts shadows, 0..1.
fn sunlit(light: u32, at: vec4<f32>, normal: vec3<f32>, view_z: f32, pixel: vec2<f32>) -> f32 {
    let sun = &lights.directional_lights[light];
    let cascade = min(get_cascade_index(light, view_z), (*sun).num_cascades - 1u);
    let texel = (*sun).cascades[cascade].texel_size;
    let offset = (*sun).shadow_normal_bias * texel * normal + (*sun).shadow_depth_bias * (*sun).direction_to_light;
    let place = world_to_directional_light_local(light, cascade, vec4(at.xyz + offset, at.w));
    let layer = i32((*sun).depth_texture_base_index + cascade);
    let shadow = sample_shadow_map(place.xy, place.z, layer, pixel, texel);
    // Outside of the map, `w` is 0.
    return select(1.0, shadow, place.w > 0.0 && -view_z < (*sun).cascades[cascade].far_bound);
}

// What a rough surface of this colour sends to the eye; `open` is how much of the sky it sees, 0..1.
fn lit(color: vec3<f32>, normal: vec3<f32>, at: vec4<f32>, pixel: vec2<f32>, open: f32, sky: SkyLight) -> vec4<f32> {
    let from_view = view.view_from_world;
    let view_z = dot(vec4(from_view[0].z, from_view[1].z, from_view[2].z, from_view[3].z), at);
    let squared = normal * normal;
    let vertical = select(sky.below.rgb, sky.above.rgb, normal.y > 0.0);
    var light = open * (squared.y * vertical + (squared.x + squared.z) * sky.around.rgb);
    for (var index = 0u; index < lights.n_directional_lights; index++) {
        let sun = &lights.directional_lights[index];
        let facing = max(dot(normal, (*sun).direction_to_light), 0.0);
        light += (*sun).color.rgb * (facing * 0.318309886 * sunlit(index, at, normal, view_z, pixel));
    }
    var seen = vec4(color * light * view.exposure, 1.0);
#ifdef DISTANCE_FOG
    seen = exponential_squared_fog(fog, seen, distance(at.xyz, view.world_position), vec3(0.0));
#endif
#ifdef TONEMAP_IN_SHADER
    seen = tone_mapping(seen, view.color_grading);
#endif
    return seen;
}
