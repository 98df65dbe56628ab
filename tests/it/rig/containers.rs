//! The file around the data, whole or broken.

use base64::{Engine, engine::general_purpose::STANDARD};

use super::*;

#[test]
fn buffers_lie_in_the_glb_in_a_file_or_in_the_uri() {
    let file = triangle();
    let bin = file.bin.clone();
    let data = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bin));
    let beside = Rig::from_slice(&file.gltf("my%20buffer.bin"), |uri| {
        assert_eq!(uri, "my buffer.bin");
        Ok(bin.clone())
    });
    let inline = Rig::from_slice(&file.gltf(&data), no_files);
    for other in [beside, inline] {
        assert_eq!(other.expect("the buffer is found").joint_bounds, rig(&file).joint_bounds);
    }
}

#[test]
fn buffers_that_are_missing_or_cut_off_are_named() {
    let file = triangle();
    let error = |bytes: &[u8], resolve: fn(&str) -> Result<Vec<u8>, String>| {
        Rig::from_slice(bytes, resolve).expect_err("the buffer is bad").to_string()
    };
    let gltf = file.gltf("legs.bin");
    assert_eq!(error(&gltf, |_| Err("not found".to_owned())), "buffer 0: `legs.bin`: not found");
    let length = file.bin.len();
    let short = format!("buffer 0: it should have {length} bytes but has 5: the file is cut off");
    assert_eq!(error(&gltf, |_| Ok(vec![0; 5])), short);
    assert_eq!(error(&file.gltf("data:,abc"), no_files), "buffer 0: its data URI is not base64");
    let mut view = file.clone();
    view.root["bufferViews"][0]["byteLength"] = json!(9999);
    let problem = format!("its view reaches beyond the {} bytes of buffer 0", length.next_multiple_of(4));
    assert_eq!(fault(&view), format!("accessor 0 (positions of mesh `sail`, primitive 0): {problem}"));
    let mut many = file;
    many.root["accessors"][0]["count"] = json!(4_000_000_000u32);
    assert!(fault(&many).contains("4000000000 elements are more than"), "{}", fault(&many));
}

#[test]
fn what_is_no_gltf_is_refused() {
    let error = |bytes: &[u8]| Rig::from_slice(bytes, no_files).expect_err("no glTF").to_string();
    assert!(error(b"").starts_with("glTF JSON: "), "{}", error(b""));
    assert!(error(b"{}").contains("asset"), "{}", error(b"{}"));
    assert_eq!(error(b"glTF"), "not a whole glTF 2.0 file: the GLB header is cut off");
    assert_eq!(error(b"glTF\x01\0\0\0\0\0\0\0"), "not a whole glTF 2.0 file: GLB version 1; only 2 is known");
    let mut file = triangle();
    file.root["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    assert!(fault(&file).contains("requires the extension `KHR_draco_mesh_compression`"), "{}", fault(&file));
}

#[test]
fn a_wrong_index_or_type_is_named() {
    let mut file = triangle();
    file.root["skins"][0]["joints"] = json!([0, 44]);
    assert!(fault(&file).starts_with("glTF element `skins[0].joints[1]`: "), "{}", fault(&file));
    let mut file = triangle();
    file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(77);
    assert!(fault(&file).contains("accessor 77 does not exist"), "{}", fault(&file));
    let mut file = triangle();
    file.root["accessors"][0]["type"] = json!("VEC4");
    let problem = "it holds Vec4, needed is Vec3";
    assert_eq!(fault(&file), format!("accessor 0 (positions of mesh `sail`, primitive 0): {problem}"));
    let mut file = triangle();
    let matrices = file.floats("MAT4", &[1.0; 16]);
    file.root["skins"][0]["inverseBindMatrices"] = json!(matrices);
    assert_eq!(fault(&file), "skin `bones`: 1 inverse bind matrices for 2 joints");
}

#[test]
fn no_cut_and_no_flipped_byte_makes_it_panic() {
    let glb = Body::default().build().glb();
    for length in (0..glb.len()).step_by(97) {
        let _ = Rig::from_slice(&glb[..length], no_files);
    }
    // A few hundred files, each with some bytes changed by a fixed generator.
    let mut state = 0x2545_f491_u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as usize
    };
    for _ in 0..300 {
        let mut broken = glb.clone();
        for _ in 0..1 + next() % 6 {
            let at = next() % broken.len();
            broken[at] = next() as u8;
        }
        let _ = Rig::from_slice(&broken, no_files);
    }
}
