// Linear blend skinning. Mirrors `SkinArena` (src/skinning/arena.rs); src/anim/skin.rs is the same on the CPU.
#define_import_path surefoot::skinning

// `InstanceRecord`: where an instance's matrices begin, how many there are (at least 1), its linear colour.
struct Instance {
    first: u32,
    count: u32,
    pad_a: u32,
    pad_b: u32,
    tint: vec4<f32>,
}

// Where this frame's and the last frame's half of the matrices begin, then every record.
struct Instances {
    current: u32,
    previous: u32,
    pad_a: u32,
    pad_b: u32,
    items: array<Instance>,
}

// A WGSL mat3x4 has three columns of four: each column here is a row of an affine matrix, so `v * m` applies it.
@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<storage, read> joint_matrices: array<mat3x4<f32>>;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var<storage, read> instances: Instances;

fn instance_tint(tag: u32) -> vec4<f32> {
    return instances.items[tag].tint;
}

// The blend of up to four matrices; a slot beyond the palette is its last one, so nobody reads a neighbour's.
// Most vertices have one or two influences: what isn't weighed isn't read.
fn blended(begin: u32, tag: u32, slots: vec4<u32>, weights: vec4<f32>) -> mat3x4<f32> {
    let first = begin + instances.items[tag].first;
    let slot = min(slots, vec4<u32>(instances.items[tag].count - 1u)) + first;
    var blend = weights.x * joint_matrices[slot.x];
    if weights.y > 0.0 {
        blend += weights.y * joint_matrices[slot.y];
    }
    if weights.z > 0.0 {
        blend += weights.z * joint_matrices[slot.z];
    }
    if weights.w > 0.0 {
        blend += weights.w * joint_matrices[slot.w];
    }
    return blend;
}

// model_from_mesh of a vertex, this frame.
fn skin_matrix(tag: u32, slots: vec4<u32>, weights: vec4<f32>) -> mat3x4<f32> {
    return blended(instances.current, tag, slots, weights);
}

// model_from_mesh of a vertex, last frame.
fn previous_skin_matrix(tag: u32, slots: vec4<u32>, weights: vec4<f32>) -> mat3x4<f32> {
    return blended(instances.previous, tag, slots, weights);
}

// `model_from_mesh`, then `world_from_model`.
fn placed(world_from_model: mat4x4<f32>, m: mat3x4<f32>) -> mat3x4<f32> {
    let rows = transpose(world_from_model);
    return mat3x4<f32>(
        rows[0].x * m[0] + rows[0].y * m[1] + rows[0].z * m[2] + vec4<f32>(0.0, 0.0, 0.0, rows[0].w),
        rows[1].x * m[0] + rows[1].y * m[1] + rows[1].z * m[2] + vec4<f32>(0.0, 0.0, 0.0, rows[1].w),
        rows[2].x * m[0] + rows[2].y * m[1] + rows[2].z * m[2] + vec4<f32>(0.0, 0.0, 0.0, rows[2].w),
    );
}

fn skin_point(m: mat3x4<f32>, point: vec3<f32>) -> vec3<f32> {
    return vec4<f32>(point, 1.0) * m;
}

// Of unit length, or zero.
fn skin_tangent(m: mat3x4<f32>, tangent: vec3<f32>) -> vec3<f32> {
    return unit_or_zero(vec4<f32>(tangent, 0.0) * m);
}

// By the cofactor matrix: right for uneven scale, shear and mirroring, and without a division. Of unit length, or zero.
fn skin_normal(m: mat3x4<f32>, normal: vec3<f32>) -> vec3<f32> {
    let yz = cross(m[1].xyz, m[2].xyz);
    let zx = cross(m[2].xyz, m[0].xyz);
    let xy = cross(m[0].xyz, m[1].xyz);
    let outward = select(1.0, -1.0, dot(m[0].xyz, yz) < 0.0);
    return unit_or_zero(outward * vec3<f32>(dot(yz, normal), dot(zx, normal), dot(xy, normal)));
}

fn unit_or_zero(v: vec3<f32>) -> vec3<f32> {
    let squared = dot(v, v);
    return select(vec3<f32>(0.0), v * inverseSqrt(squared), squared > 0.0);
}
