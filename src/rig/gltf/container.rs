//! The file around the data: GLB chunks, JSON, required extensions, buffers.

use base64::{Engine, engine::general_purpose::STANDARD};
use gltf::json::{
    Root,
    validation::{Error as Rule, Validate},
};

use super::error::RigError;

/// Required extensions that leave joints, weights and keys readable. All `KHR_materials_*`, VRM and texture ones do, too.
const HARMLESS: [&str; 2] = ["KHR_mesh_quantization", "KHR_lights_punctual"];

/// A parsed file whose buffers may still lie elsewhere.
pub(crate) struct Container {
    pub(super) json: Root,
    blob: Option<Vec<u8>>,
}

impl Container {
    /// Reads `.glb` or `.gltf` bytes.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, RigError> {
        let (json, blob) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
        let json = Root::from_slice(json).map_err(|error| RigError::Json(error.to_string()))?;
        check_attributes(&json)?;
        if let Some(name) = json.extensions_required.iter().find(|name| !is_harmless(name)) {
            return Err(RigError::Extension(name.clone()));
        }
        let mut broken = None;
        json.validate(&json, gltf::json::Path::new, &mut |path, error| {
            let path = path().to_string();
            if !is_tolerated(&path) && broken.is_none() {
                broken = Some(RigError::Element { path, problem: rule(&error).to_owned() });
            }
        });
        match broken {
            Some(error) => Err(error),
            None => Ok(Self { json, blob }),
        }
    }

    /// Paths of the buffers that lie in other files, percent-decoded.
    pub(crate) fn external_buffers(&self) -> impl Iterator<Item = String> {
        let uris = self.json.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
        uris.filter(|uri| !uri.starts_with("data:")).map(percent_decoded)
    }

    /// All buffers; `resolve` gives the bytes behind a relative, percent-decoded path.
    pub(crate) fn buffers(
        &mut self,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Vec<Vec<u8>>, RigError> {
        let mut blob = self.blob.take();
        let read = |(index, buffer): (usize, &gltf::json::Buffer)| {
            let fail = |problem: String| RigError::Buffer { buffer: index, problem };
            let bytes = match buffer.uri.as_deref() {
                None => blob.take().ok_or_else(|| fail("it has no uri and the file has no binary chunk".to_owned()))?,
                Some(uri) => match uri.strip_prefix("data:") {
                    Some(data) => {
                        let (_, encoded) =
                            data.split_once(";base64,").ok_or_else(|| fail("its data URI is not base64".to_owned()))?;
                        STANDARD.decode(encoded).map_err(|error| fail(format!("its data URI: {error}")))?
                    }
                    None => resolve(&percent_decoded(uri)).map_err(|error| fail(format!("`{uri}`: {error}")))?,
                },
            };
            let (have, need) = (bytes.len() as u64, buffer.byte_length.0);
            if have < need {
                return Err(fail(format!("it should have {need} bytes but has {have}: the file is cut off")));
            }
            Ok(bytes)
        };
        self.json.buffers.iter().enumerate().map(read).collect()
    }
}

/// JSON chunk and binary chunk of a GLB file.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<Vec<u8>>), RigError> {
    let fail = |problem: &str| RigError::Container(problem.to_owned());
    let word = |at: usize| -> Result<u32, RigError> {
        let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes).ok_or_else(|| fail("the GLB header is cut off"))
    };
    let version = word(4)?;
    if version != 2 {
        return Err(fail(&format!("GLB version {version}; only 2 is known")));
    }
    let mut at = 12;
    let (mut json, mut blob) = (None, None);
    while at < bytes.len() && (json.is_none() || blob.is_none()) {
        let (length, kind) = (word(at)? as usize, word(at + 4)?);
        let chunk = bytes
            .get(at + 8..)
            .and_then(|rest| rest.get(..length))
            .ok_or_else(|| fail(&format!("a GLB chunk of {length} bytes is cut off")))?;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" => blob = Some(chunk.to_vec()),
            _ => {}
        }
        at += 8 + length;
    }
    Ok((json.ok_or_else(|| fail("the GLB has no JSON chunk"))?, blob))
}

/// The format crate's own check takes these indices for granted.
fn check_attributes(json: &Root) -> Result<(), RigError> {
    for (mesh, it) in json.meshes.iter().enumerate() {
        for (primitive, it) in it.primitives.iter().enumerate() {
            if let Some(accessor) = it.attributes.values().find(|index| index.value() >= json.accessors.len()) {
                return Err(RigError::Element {
                    path: format!("meshes[{mesh}].primitives[{primitive}].attributes"),
                    problem: format!(
                        "accessor {} does not exist; there are {}",
                        accessor.value(),
                        json.accessors.len()
                    ),
                });
            }
        }
    }
    Ok(())
}

fn is_harmless(extension: &str) -> bool {
    HARMLESS.contains(&extension)
        || ["KHR_materials_", "VRM"].iter().any(|start| extension.starts_with(start))
        || extension.contains("_texture_")
}

/// Required extensions are checked apart; bounds of positions are not needed here.
fn is_tolerated(path: &str) -> bool {
    path.starts_with("extensionsRequired")
        || (path.contains("POSITION") && (path.ends_with("min") || path.ends_with("max")))
}

fn rule(error: &Rule) -> &'static str {
    match error {
        Rule::IndexOutOfBounds => "the index points beyond what the file has",
        Rule::Invalid => "the value is not one that glTF knows",
        Rule::Missing => "it is missing",
        _ => "it breaks a rule of the format",
    }
}

/// `%20` and the like as bytes; anything that is not a whole escape stays as written.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let escape = (first == b'%').then(|| tail.get(..2)).flatten().and_then(|hex| core::str::from_utf8(hex).ok());
        match escape.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|_| uri.to_owned())
}
