// Cheap patterns over the plan, in metres.
#define_import_path surefoot::noise

// 0..1 for a whole-numbered cell; float arithmetic, which software rasterisers do faster than whole numbers.
// Source: Dave Hoskins, "Hash without Sine" (shadertoy.com/view/4djSRW).
fn hash(cell: vec2<f32>) -> f32 {
    var p = fract(cell.xyx * 0.1031);
    p += dot(p, p.yzx + 33.33);
    return fract((p.x + p.y) * p.z);
}

// 0..1, smooth, one lump per unit.
fn value_noise(at: vec2<f32>) -> f32 {
    let low = floor(at);
    let part = at - low;
    let blend = part * part * (3.0 - 2.0 * part);
    let near = mix(hash(low), hash(low + vec2(1.0, 0.0)), blend.x);
    let far = mix(hash(low + vec2(0.0, 1.0)), hash(low + vec2(1.0, 1.0)), blend.x);
    return mix(near, far, blend.y);
}

// How much of this pixel lies on the lines of a grid, 0..1; `step` is what one pixel covers of the plan.
fn grid_lines(at: vec2<f32>, step: vec2<f32>, spacing: f32, width: f32) -> f32 {
    let off = abs(fract(at / spacing - 0.5) - 0.5) * spacing;
    let wide = max(vec2(width), step);
    let cover = clamp((wide - off) / step + 0.5, vec2(0.0), vec2(1.0)) * (width / wide);
    return max(cover.x, cover.y);
}
