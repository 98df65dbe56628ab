//! Accessors → numbers: every component type, normalised integers, strides, sparse values; every range is checked.

use gltf::json::{
    Root,
    accessor::{ComponentType, Type},
    validation::Checked,
};

use super::error::RigError;

/// More elements than this are a broken file, not a character: guards against asking for all memory.
const MAX_COUNT: u64 = 1 << 24;

/// The file's JSON and its buffers.
pub(super) struct Source<'a> {
    pub(super) json: &'a Root,
    pub(super) buffers: &'a [Vec<u8>],
}

/// All components of an accessor without gaps.
struct Dense {
    bytes: Vec<u8>,
    kind: ComponentType,
    normalized: bool,
}

impl Source<'_> {
    /// Elements of `index` as floats; normalised integers become -1..=1 or 0..=1, others keep their value.
    pub(super) fn floats<const WIDTH: usize>(
        &self,
        index: usize,
        shape: Type,
        used_by: &dyn Fn() -> String,
    ) -> Result<Vec<[f32; WIDTH]>, RigError> {
        let dense = self.dense(index, shape, used_by)?;
        let size = component_size(dense.kind);
        let number = |at: usize| component(&dense.bytes[at..at + size], dense.kind, dense.normalized);
        let element = |start: usize| core::array::from_fn(|i| number(start + i * size));
        Ok((0..dense.bytes.len()).step_by(size * WIDTH).map(element).collect())
    }

    /// Elements of `index` as whole numbers.
    pub(super) fn whole(&self, index: usize, shape: Type, used_by: &dyn Fn() -> String) -> Result<Vec<u32>, RigError> {
        let dense = self.dense(index, shape, used_by)?;
        let number = |raw: &[u8]| match (dense.kind, raw) {
            (ComponentType::U8, &[a]) => Some(u32::from(a)),
            (ComponentType::U16, &[a, b]) => Some(u32::from(u16::from_le_bytes([a, b]))),
            (ComponentType::U32, &[a, b, c, d]) => Some(u32::from_le_bytes([a, b, c, d])),
            _ => None,
        };
        let numbers: Option<Vec<u32>> = dense.bytes.chunks_exact(component_size(dense.kind)).map(number).collect();
        numbers.ok_or_else(|| RigError::Accessor {
            accessor: index,
            used_by: used_by(),
            problem: format!("it holds {:?}, needed are unsigned whole numbers", dense.kind),
        })
    }

    fn dense(&self, index: usize, wanted: Type, used_by: &dyn Fn() -> String) -> Result<Dense, RigError> {
        let fail = |problem: String| RigError::Accessor { accessor: index, used_by: used_by(), problem };
        let accessor = self.json.accessors.get(index).ok_or_else(|| fail("it does not exist".to_owned()))?;
        let (Checked::Valid(kind), Checked::Valid(shape)) = (accessor.component_type, accessor.type_) else {
            return Err(fail("its type is unknown".to_owned()));
        };
        if shape != wanted {
            return Err(fail(format!("it holds {shape:?}, needed is {wanted:?}")));
        }
        if accessor.count.0 > MAX_COUNT {
            return Err(fail(format!("{} elements are more than the {MAX_COUNT} allowed", accessor.count.0)));
        }
        let kind = kind.0;
        let (count, element) = (accessor.count.0 as usize, component_size(kind) * component_count(shape));
        let mut bytes = match accessor.buffer_view {
            None => vec![0; count * element],
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                self.elements(view.value(), offset, count, element).map_err(fail)?
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(slot_kind) = sparse.indices.component_type else {
                return Err(fail("its sparse indices have an unknown type".to_owned()));
            };
            if sparse.count.0 > accessor.count.0 {
                return Err(fail(format!("{} sparse values for {count} elements", sparse.count.0)));
            }
            let (changes, slot_size) = (sparse.count.0 as usize, component_size(slot_kind.0));
            let indices = &sparse.indices;
            let slots = self
                .elements(indices.buffer_view.value(), indices.byte_offset.0, changes, slot_size)
                .map_err(|problem| fail(format!("sparse indices: {problem}")))?;
            let values = self
                .elements(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, changes, element)
                .map_err(|problem| fail(format!("sparse values: {problem}")))?;
            for (slot, value) in slots.chunks_exact(slot_size).zip(values.chunks_exact(element)) {
                let slot = slot.iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte));
                let place = bytes.get_mut(slot.saturating_mul(element)..).and_then(|rest| rest.get_mut(..element));
                place.ok_or_else(|| fail(format!("sparse index {slot} is beyond {count}")))?.copy_from_slice(value);
            }
        }
        Ok(Dense { bytes, kind, normalized: accessor.normalized })
    }

    /// `count` elements of `element` bytes from a view, without the gaps of its stride.
    fn elements(&self, view: usize, offset: u64, count: usize, element: usize) -> Result<Vec<u8>, String> {
        let view = self.json.buffer_views.get(view).ok_or_else(|| format!("buffer view {view} does not exist"))?;
        let buffer = view.buffer.value();
        let bytes = self.buffers.get(buffer).ok_or_else(|| format!("buffer {buffer} does not exist"))?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let range = usize::try_from(start).ok().zip(usize::try_from(view.byte_length.0).ok());
        let bytes = range
            .and_then(|(start, length)| bytes.get(start..start.checked_add(length)?))
            .ok_or_else(|| format!("its view reaches beyond the {} bytes of buffer {buffer}", bytes.len()))?;
        // A stride below the element's size would overlap elements; the format's check has refused those above 252.
        let stride = view.byte_stride.map_or(element, |stride| stride.0.max(element));
        let need = if count == 0 { 0 } else { stride * (count - 1) + element };
        let bytes = usize::try_from(offset)
            .ok()
            .and_then(|offset| bytes.get(offset..offset.checked_add(need)?))
            .ok_or_else(|| format!("{need} bytes from {offset} on reach beyond its view of {} bytes", bytes.len()))?;
        if stride == element {
            return Ok(bytes.to_vec());
        }
        Ok(bytes.chunks(stride).flat_map(|chunk| &chunk[..element]).copied().collect())
    }
}

fn component_size(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

fn component_count(shape: Type) -> usize {
    match shape {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

/// One component; `raw` has as many bytes as `kind` says.
fn component(raw: &[u8], kind: ComponentType, normalized: bool) -> f32 {
    let scaled = |value: f32, full: f32| if normalized { (value / full).max(-1.0) } else { value };
    match (kind, raw) {
        (ComponentType::I8, &[a]) => scaled(f32::from(i8::from_le_bytes([a])), 127.0),
        (ComponentType::U8, &[a]) => scaled(f32::from(a), 255.0),
        (ComponentType::I16, &[a, b]) => scaled(f32::from(i16::from_le_bytes([a, b])), 32_767.0),
        (ComponentType::U16, &[a, b]) => scaled(f32::from(u16::from_le_bytes([a, b])), 65_535.0),
        (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
        (ComponentType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
        _ => 0.0,
    }
}
