//! Expressions of VRM models: `VRMC_vrm.expressions` (1.0) and `VRM.blendShapeMaster` (0.x).
//!
//! After <https://github.com/vrm-c/vrm-specification>. Of an expression its morph weights are taken, not what it does to colours
//! and textures. What can't be read is left out and noted by its place in the file.

use gltf::json::Root;
use serde_json::Value;

use super::nodes::{self, Nodes};
use crate::rig::{
    MeshBinding,
    expressions::{Expression, ExpressionBind, Override},
};

/// Names of presets in 0.x and in 1.0.
const PRESETS: [(&str, &str); 17] = [
    ("neutral", "neutral"),
    ("a", "aa"),
    ("i", "ih"),
    ("u", "ou"),
    ("e", "ee"),
    ("o", "oh"),
    ("blink", "blink"),
    ("blink_l", "blinkLeft"),
    ("blink_r", "blinkRight"),
    ("joy", "happy"),
    ("angry", "angry"),
    ("sorrow", "sad"),
    ("fun", "relaxed"),
    ("lookup", "lookUp"),
    ("lookdown", "lookDown"),
    ("lookleft", "lookLeft"),
    ("lookright", "lookRight"),
];

/// What binds are looked up in, and where it is noted what is left out.
struct Reader<'a> {
    json: &'a Root,
    nodes: &'a Nodes,
    meshes: &'a [MeshBinding],
    notes: &'a mut Vec<String>,
}

/// Expressions of the file; none where it brings none.
pub(super) fn read(json: &Root, nodes: &Nodes, meshes: &[MeshBinding], notes: &mut Vec<String>) -> Vec<Expression> {
    let extension = |name: &str| json.extensions.as_ref().and_then(|extensions| extensions.others.get(name));
    let mut reader = Reader { json, nodes, meshes, notes };
    let mut found = Vec::new();
    if let Some(expressions) = extension("VRMC_vrm").and_then(|vrm| vrm.get("expressions")) {
        for kind in ["preset", "custom"] {
            for (name, value) in expressions.get(kind).and_then(Value::as_object).into_iter().flatten() {
                found.push((format!("VRMC_vrm.expressions.{kind}.{name}"), reader.expression(kind, name, value)));
            }
        }
    } else if let Some(groups) = extension("VRM").and_then(|vrm| vrm.pointer("/blendShapeMaster/blendShapeGroups")) {
        for (index, value) in groups.as_array().into_iter().flatten().enumerate() {
            let path = format!("VRM.blendShapeMaster.blendShapeGroups[{index}]");
            let group = reader.group(&path, value);
            found.push((path, group));
        }
    }
    let mut expressions: Vec<Expression> = Vec::new();
    for (path, expression) in found {
        let name = &expression.name;
        if name.is_empty() || expressions.iter().any(|other| other.name == *name) {
            let problem = if name.is_empty() { "it has no name" } else { "there is another of its name" };
            notes.push(format!("`{path}`: {problem}; it is left out"));
        } else {
            expressions.push(expression);
        }
    }
    expressions
}

impl Reader<'_> {
    /// One of VRM 1.0.
    fn expression(&mut self, kind: &str, name: &str, value: &Value) -> Expression {
        let overrides = |field: &str| match value.get(field).and_then(Value::as_str) {
            Some("block") => Override::Block,
            Some("blend") => Override::Blend,
            _ => Override::None,
        };
        let mut expression = Expression {
            name: name.to_owned(),
            binds: Vec::new(),
            binary: is_binary(value),
            blink: overrides("overrideBlink"),
            mouth: overrides("overrideMouth"),
        };
        for (index, bind) in value.get("morphTargetBinds").and_then(Value::as_array).into_iter().flatten().enumerate() {
            let path = format!("VRMC_vrm.expressions.{kind}.{name}.morphTargetBinds[{index}]");
            let (json, nodes) = (self.json, self.nodes);
            let carrier = place(bind, "node").and_then(|node| match nodes.joints.get(node) {
                None => Err(format!("node {node} does not exist; there are {}", nodes.joints.len())),
                Some(joint) => Ok((*joint, format!("node `{}`", nodes::name(json, node)))),
            });
            let of = carrier.map(|(joint, name)| (name, move |mesh: &MeshBinding| Some(mesh.joint) == joint));
            self.bind(&path, bind, of, 1.0, &mut expression);
        }
        expression
    }

    /// One of VRM 0.x.
    fn group(&mut self, path: &str, value: &Value) -> Expression {
        let text = |field: &str| value.get(field).and_then(Value::as_str).unwrap_or_default();
        let preset = PRESETS.into_iter().find(|(old, _)| text("presetName").eq_ignore_ascii_case(old));
        let name = preset.map_or_else(|| text("name"), |(_, new)| new);
        let mut expression = Expression { name: name.to_owned(), binary: is_binary(value), ..Expression::default() };
        for (index, bind) in value.get("binds").and_then(Value::as_array).into_iter().flatten().enumerate() {
            let path = format!("{path}.binds[{index}] (`{name}`)");
            let count = self.json.meshes.len();
            let carrier = place(bind, "mesh").and_then(|mesh| {
                if mesh < count { Ok(mesh) } else { Err(format!("mesh {mesh} does not exist; there are {count}")) }
            });
            let of = carrier.map(|at| (format!("mesh {at}"), move |mesh: &MeshBinding| mesh.mesh == at));
            self.bind(&path, bind, of, 100.0, &mut expression);
        }
        expression
    }

    /// Adds what `bind` says of the meshes that it means; its weights go up to `full`.
    fn bind(
        &mut self,
        path: &str,
        bind: &Value,
        of: Result<(String, impl Fn(&MeshBinding) -> bool), String>,
        full: f32,
        expression: &mut Expression,
    ) {
        let read = || -> Result<(Vec<ExpressionBind>, Option<f32>), String> {
            let (carrier, is_meant) = of?;
            let target = place(bind, "index")?;
            let asked = bind.get("weight").and_then(Value::as_f64).map(|weight| weight as f32 / full);
            let asked = asked.filter(|weight| weight.is_finite()).ok_or("its weight is not a finite number")?;
            let weight = asked.clamp(0.0, 1.0);
            let mut meant = self.meshes.iter().enumerate().filter(|(_, mesh)| is_meant(mesh)).peekable();
            if meant.peek().is_none() {
                return Err(format!("{carrier} draws no mesh"));
            }
            let bind = |(place, mesh): (usize, &MeshBinding)| match mesh.morph_names.len() {
                count if target >= count => Err(format!("{carrier} has no morph target {target}; there are {count}")),
                _ => Ok(ExpressionBind { mesh: place, target, weight }),
            };
            let beyond = asked.to_bits() != weight.to_bits() && asked.abs() > 0.0;
            Ok((meant.map(bind).collect::<Result<_, _>>()?, beyond.then_some(asked)))
        };
        match read() {
            Ok((binds, beyond)) => {
                expression.binds.extend(binds);
                if let Some(asked) = beyond {
                    self.notes.push(format!("`{path}`: its weight {asked} is not from 0 to 1; the nearest is taken"));
                }
            }
            Err(problem) => self.notes.push(format!("`{path}`: {problem}; it is left out")),
        }
    }
}

fn is_binary(value: &Value) -> bool {
    value.get("isBinary").and_then(Value::as_bool).unwrap_or(false)
}

/// The index that `field` holds.
fn place(value: &Value, field: &str) -> Result<usize, String> {
    let index = value.get(field).and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
    index.ok_or_else(|| format!("its `{field}` is no index"))
}
