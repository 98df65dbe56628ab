// Paints built things; mirrors `CourseLook` in src/terrain/material.rs.
// Vertex colour: the thing's own colour; the fourth number is how open the place is to the sky.
#import bevy_pbr::pbr_fragment::pbr_input_from_standard_material
#import surefoot::noise::value_noise

#ifdef PREPASS_PIPELINE
#import bevy_pbr::{
    pbr_deferred_functions::deferred_output,
    prepass_io::{FragmentOutput, VertexOutput},
}
#else
#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}
#endif

struct CourseLook {
    grain: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> look: CourseLook;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr = pbr_input_from_standard_material(in, is_front);
    let at = in.world_position.xyz;
    let across = select(vec2(at.x + at.z, at.y), at.xz, abs(pbr.N.y) > 0.6);
    let grain = value_noise(across * 1.3) + value_noise(across * 6.1) - 1.0;
    let open = in.color.a;
    pbr.material.base_color = vec4(in.color.rgb * (1.0 + look.grain * grain) * (0.55 + 0.45 * open), 1.0);
    pbr.diffuse_occlusion = vec3(open);

#ifdef PREPASS_PIPELINE
    return deferred_output(in, pbr);
#else
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr, apply_pbr_lighting(pbr));
    return out;
#endif
}
