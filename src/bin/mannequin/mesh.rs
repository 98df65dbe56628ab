//! The mesh as it goes into the file: one list of vertices and triangles per material.
//!
//! Model space, metres; colours linear.

use glam::Vec3;

/// What a primitive looks like. Vertex colours multiply the base colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// Fabric and rubber.
    Undersuit,
    /// Plates and paint.
    Shell,
    /// The dark glass of the helmet.
    Visor,
    /// What shines by itself.
    Glow,
}

/// All materials, in the order of the file's primitives.
pub const MATERIALS: [Material; 4] = [Material::Undersuit, Material::Shell, Material::Visor, Material::Glow];

/// Up to four joints and their shares.
pub type Influences = [(usize, f32); 4];

/// One vertex.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Rest position.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Linear colour, 0..1.
    pub color: Vec3,
    /// Joints that carry it.
    pub influences: Influences,
}

/// Vertices and triangles of one material.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds all of `other`.
    pub fn append(&mut self, other: &Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
    }

    /// The same mesh on the other side of x = 0, on the joints of the other side.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let flip = |p: Vec3| Vec3::new(-p.x, p.y, p.z);
        let vertices = self.vertices.iter().map(|v| Vertex {
            position: flip(v.position),
            normal: flip(v.normal),
            color: v.color,
            influences: v.influences.map(|(joint, share)| (crate::skeleton::opposite(joint), share)),
        });
        Self { vertices: vertices.collect(), triangles: self.triangles.iter().map(|t| [t[0], t[2], t[1]]).collect() }
    }

    /// Joins the vertices of a half mesh's two sides along x = 0.
    #[must_use]
    pub fn both_halves(&self) -> Self {
        let mut whole = self.clone();
        let mut image = Vec::with_capacity(self.vertices.len());
        for (i, vertex) in self.mirrored().vertices.into_iter().enumerate() {
            if vertex.position.x == 0.0 {
                whole.vertices[i].normal.x = 0.0;
                whole.vertices[i].normal = whole.vertices[i].normal.normalize_or(Vec3::Y);
                image.push(i as u32);
            } else {
                image.push(whole.vertices.len() as u32);
                whole.vertices.push(vertex);
            }
        }
        whole.triangles.extend(self.triangles.iter().map(|t| [t[0], t[2], t[1]].map(|v| image[v as usize])));
        whole
    }
}
