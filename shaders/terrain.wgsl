// Paints the ground; mirrors `GroundLook` in src/terrain/material.rs.
// Vertex colour: red path, green bare ground, blue shade under obstacles, alpha broad patches.
#import bevy_pbr::forward_io::{FragmentOutput, VertexOutput}
#import surefoot::light::{SkyLight, lit}
#import surefoot::noise::{grid_lines, hash, value_noise}

struct GroundLook {
    grass: vec4<f32>,
    dry_grass: vec4<f32>,
    dirt: vec4<f32>,
    rock: vec4<f32>,
    paving: vec4<f32>,
    plaza: vec4<f32>,
    sky: SkyLight,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> look: GroundLook;

// Metres from the plaza's edge, negative inside.
fn plaza_distance(at: vec2<f32>) -> f32 {
    let beyond = abs(at) - look.plaza.xy + look.plaza.z;
    return length(max(beyond, vec2(0.0))) + min(max(beyond.x, beyond.y), 0.0) - look.plaza.z;
}

fn paving(at: vec2<f32>, step: vec2<f32>, fine: f32) -> vec3<f32> {
    let slab = look.plaza.w;
    let tone = 0.93 + 0.1 * hash(floor(at / slab)) + 0.05 * (fine - 0.5);
    let joint = grid_lines(at, step, slab, 0.012);
    let field = grid_lines(at, step, slab * 5.0, 0.03);
    return look.paving.rgb * tone * (1.0 - 0.35 * joint) * (1.0 - 0.3 * field);
}

fn meadow(at: vec2<f32>, step: vec2<f32>, height: f32, coarse: f32, fine: f32, near: f32) -> vec3<f32> {
    let dry = smoothstep(0.35, 0.75, 0.75 * coarse + 0.3 * fine * near + 0.028 * height);
    let grass = mix(look.grass.rgb, look.dry_grass.rgb, dry);
    // A faint grid keeps scale and speed readable where nothing else does.
    let metre = grid_lines(at, step, 1.0, 0.025) * near;
    let five = grid_lines(at, step, 5.0, 0.04);
    return grass * (0.8 + 0.4 * mix(0.5, fine, near)) * (1.0 - 0.13 * metre - 0.16 * five);
}

@fragment
fn fragment(in: VertexOutput) -> FragmentOutput {
    let at = in.world_position.xz;
    let step = max(fwidth(at), vec2(1e-4));
    // Detail fades before it would flicker.
    let near = clamp(1.4 - 2.2 * max(step.x, step.y), 0.0, 1.0);
    let coarse = in.color.a;
    let fine = value_noise(at * vec2(9.1, 11.3)) * 0.45 + value_noise(at * 2.3) * 0.55;
    let ragged = (fine - 0.5) * near + (coarse - 0.5);

    var color = meadow(at, step, in.world_position.y, coarse, fine, near);
    let trodden = max(in.color.r, in.color.g);
    let dirt = smoothstep(0.3, 0.65, trodden + 0.5 * ragged);
    color = mix(color, look.dirt.rgb * (0.85 + 0.3 * fine), dirt);
    let normal = normalize(in.world_normal);
    let steep = 1.0 - normal.y;
    let rock = smoothstep(0.13, 0.2, steep + 0.06 * ragged);
    color = mix(color, look.rock.rgb * (0.6 + 0.4 * coarse + 0.3 * (fine - 0.5) * near), rock);
    let edge = plaza_distance(at);
    let inside = clamp(0.5 - edge / max(step.x, step.y), 0.0, 1.0);
    color = mix(color, paving(at, step, fine), inside);
    // A kerb stone around the plaza.
    let kerb = clamp(0.5 + (0.16 - abs(edge + 0.16)) / max(step.x, step.y), 0.0, 1.0);
    color = mix(color, look.paving.rgb * 0.62, kerb);

    let open = 1.0 - in.color.b;
    var out: FragmentOutput;
    out.color = lit(color * (0.4 + 0.6 * open), normal, in.world_position, in.position.xy, open, look.sky);
    return out;
}
