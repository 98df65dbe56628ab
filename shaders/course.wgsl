// Paints built things; mirrors `CourseLook` in src/terrain/material.rs.
// Vertex colour: the thing's own colour; the fourth number is how open the place is to the sky.
#import bevy_pbr::forward_io::{FragmentOutput, VertexOutput}
#import surefoot::light::{SkyLight, lit}
#import surefoot::noise::value_noise

struct CourseLook {
    grain: f32,
    sky: SkyLight,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> look: CourseLook;

@fragment
fn fragment(in: VertexOutput) -> FragmentOutput {
    let at = in.world_position.xyz;
    let normal = normalize(in.world_normal);
    let across = select(vec2(at.x + at.z, at.y), at.xz, abs(normal.y) > 0.6);
    let grain = value_noise(across * 1.3) + value_noise(across * 6.1) - 1.0;
    let open = in.color.a;
    let color = in.color.rgb * (1.0 + look.grain * grain) * (0.55 + 0.45 * open);
    var out: FragmentOutput;
    out.color = lit(color, normal, in.world_position, in.position.xy, open, look.sky);
    return out;
}
