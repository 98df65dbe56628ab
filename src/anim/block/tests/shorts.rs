//! Rows of 16 bits.

use super::{
    reference::{Body, body},
    *,
};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn rows_of_16_bits_are_half_as_large_and_as_exact_as_they_say(body in body(8..40, 0.0)) {
        let Body { skeleton, skin, clips, .. } = &body;
        let of = |precision| {
            let clips = [RowSource::new(&clips[0], precision)];
            Species::new(&SpeciesParts { skeleton, skin, limbs: &[], clips: &clips, masks: &[] }).unwrap()
        };
        let (short, float) = (of(Precision::Short), of(Precision::Float));
        let (report, whole) = (short.clips()[0].report(), float.clips()[0].report());
        prop_assert!(report.bytes * 2 <= whole.bytes + 1024, "{} bytes of {}", report.bytes, whole.bytes);
        let size = skeleton.model_from_root.x_axis.length() * 10.0;
        prop_assert!(report.max_error > 0.0 && report.max_error < 2e-4 * size.max(0.1), "{} m off", report.max_error);
        // On frames, where the report was taken, a palette's translation is off by no more, within rounding.
        let frame = body.clips[0].frame_count() / 2;
        let clips = [Play { clip: 0, time: frame as f32 / body.clips[0].frame_rate(), weight: 1.0 }];
        let layers = [Layer { weight: 1.0, clips: &clips, ..Layer::default() }];
        let actor = Actor { layers: &layers, ..Actor::default() };
        let (a, b) = (&palettes(&short, &[actor])[0], &palettes(&float, &[actor])[0]);
        prop_assert!(difference(a, b) < 2e-3, "{:e} off", difference(a, b));
    }
}
