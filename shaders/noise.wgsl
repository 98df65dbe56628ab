// Cheap patterns over the plan, in metres.
#define_import_path surefoot::noise

fn hash(cell: vec2<i32>) -> f32 {
    var h = bitcast<u32>(cell.x) * 0x9E3779B1u ^ bitcast<u32>(cell.y) * 0x85EBCA77u;
    h = (h ^ (h >> 15u)) * 0x2C1B3C6Du;
    h = h ^ (h >> 12u);
    return f32(h & 0xFFFFu) / 65535.0;
}

// 0..1, smooth, one lump per unit.
fn value_noise(at: vec2<f32>) -> f32 {
    let low = floor(at);
    let part = at - low;
    let blend = part * part * (3.0 - 2.0 * part);
    let cell = vec2<i32>(low);
    let near = mix(hash(cell), hash(cell + vec2(1, 0)), blend.x);
    let far = mix(hash(cell + vec2(0, 1)), hash(cell + vec2(1, 1)), blend.x);
    return mix(near, far, blend.y);
}

// How much of this pixel lies on the lines of a grid, 0..1; `step` is what one pixel covers of the plan.
fn grid_lines(at: vec2<f32>, step: vec2<f32>, spacing: f32, width: f32) -> f32 {
    let off = abs(fract(at / spacing - 0.5) - 0.5) * spacing;
    let wide = max(vec2(width), step);
    let cover = clamp((wide - off) / step + 0.5, vec2(0.0), vec2(1.0)) * (width / wide);
    return max(cover.x, cover.y);
}
