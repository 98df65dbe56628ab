//! Bakes the mannequin: skeleton, mesh and clips, all from code, into one binary glTF file.
//!
//! `mannequin [--out FILE]`; the default file is `assets/mannequin.glb`. The same source gives the same bytes.

#![expect(unreachable_pub, reason = "`pub` here means: for the other modules")]

mod clip;
mod clips;
mod glb;
mod mesh;
mod morphs;
mod occlusion;
mod shape;
mod shell;
mod simplify;
mod skeleton;
mod soft;
mod surface;
mod turn;
mod weights;

use std::{error::Error, path::PathBuf};

use mesh::{MATERIALS, Material, Mesh};

fn main() -> Result<(), Box<dyn Error>> {
    let out = out_file(std::env::args().skip(1))?;
    std::fs::write(&out, bake()).map_err(|error| format!("{}: {error}", out.display()))?;
    Ok(())
}

fn out_file(mut args: impl Iterator<Item = String>) -> Result<PathBuf, String> {
    match (args.next().as_deref(), args.next(), args.next()) {
        (None, ..) => Ok(PathBuf::from("assets/mannequin.glb")),
        (Some("--out"), Some(file), None) => Ok(PathBuf::from(file)),
        (Some(other), ..) => Err(format!("unexpected `{other}`; usage: mannequin [--out FILE]")),
    }
}

/// The bytes of the file.
fn bake() -> Vec<u8> {
    let mut parts = vec![(Material::Undersuit, soft::soft())];
    parts.extend(shell::hard());
    let mut meshes = MATERIALS.map(|material| {
        let mut mesh = Mesh::default();
        parts.iter().filter(|part| part.0 == material).for_each(|part| mesh.append(&part.1));
        (material, mesh)
    });
    occlusion::bake(&mut meshes);
    glb::write(&meshes, &clips::all())
}
