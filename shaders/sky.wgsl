// Draws the sky on the inside of its dome; mirrors `SkyMaterial` in src/terrain/material.rs.
#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    mesh_view_bindings::view,
}
#import surefoot::noise::value_noise
#ifdef TONEMAP_IN_SHADER
#import bevy_core_pipeline::tonemapping::tone_mapping
#endif

struct SkyLook {
    horizon: vec4<f32>,
    zenith: vec4<f32>,
    sun: vec4<f32>,
    to_sun: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> look: SkyLook;

@fragment
fn fragment(in: VertexOutput) -> FragmentOutput {
    let toward = normalize(in.world_position.xyz - view.world_position);
    let up = max(toward.y, 0.0);
    var color = mix(look.horizon.rgb, look.zenith.rgb, 1.0 - exp(-3.2 * up));
    // Thin clouds on a plane far above, fading into the haze.
    let plane = toward.xz / max(toward.y + 0.12, 0.05);
    let cloud = 0.62 * value_noise(plane * 1.1) + 0.38 * value_noise(plane * vec2(3.1, 2.6) + 7.0);
    color = mix(color, vec3(1.5), 0.55 * smoothstep(0.5, 0.85, cloud) * smoothstep(0.02, 0.3, up));
    let toward_sun = max(dot(toward, look.to_sun.xyz), 0.0);
    let halo = pow(toward_sun, 8.0) * 0.12 + pow(toward_sun, 160.0) * 0.5 + smoothstep(0.9994, 0.9997, toward_sun) * 4.0;
    color += look.sun.rgb * halo;

    var out: FragmentOutput;
    out.color = vec4(color, 1.0);
#ifdef TONEMAP_IN_SHADER
    out.color = tone_mapping(out.color, view.color_grading);
#endif
    return out;
}
