//! Footprint tables against the kernels they sample: sizes, look-ups, and the error bounds of huang2000 section 5.

use splatvol_core::radial::{AnySection, FootprintTable, Precision, RadialKernel, Spacing, TableSettings};
use splatvol_scene::Kernel;

const KERNELS: [Kernel; 4] = [
    Kernel::Gaussian {
        sigma: 0.602,
        radius: 2.0,
    },
    Kernel::CrawfisMax,
    Kernel::CubicBspline,
    Kernel::KAISER_BESSEL,
];

fn table(kernel: Kernel, settings: TableSettings) -> FootprintTable {
    FootprintTable::new(kernel, settings).expect("settings within their domain")
}

/// Largest error of whole footprints over a fine sample of squared distances, in 256ths of the peak.
fn largest_error(kernel: Kernel, settings: TableSettings) -> f64 {
    let (table, radial) = (table(kernel, settings), RadialKernel::new(kernel));
    let scale = 256.0 / radial.line_integral(0.0);
    (0..=20_000)
        .map(|i| (f64::from(i) / 20_000.0).powi(2))
        .map(|rho2| {
            let exact = radial.line_integral(rho2 * radial.support().powi(2));
            scale * (f64::from(table.value(rho2 as f32)) - exact).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn sizes_are_those_of_the_paper() {
    let bytes = |entries, precision| {
        let settings = TableSettings {
            entries,
            precision,
            ..TableSettings::default()
        };
        table(Kernel::CrawfisMax, settings).bytes()
    };
    assert_eq!(bytes(64, Precision::U8), 8 << 10);
    assert_eq!(bytes(256, Precision::U8), 32 << 10);
    assert_eq!(bytes(256, Precision::U16), 64 << 10);
    assert_eq!(bytes(256, Precision::F32), 128 << 10);
}

#[test]
fn two_levels_hold_for_a_sigma_of_two_fifths_of_the_radius() {
    let error = |sigma, spacing, precision| {
        let settings = TableSettings {
            entries: 256,
            precision,
            spacing,
            sections: 1,
        };
        largest_error(Kernel::Gaussian { sigma, radius: 2.0 }, settings)
    };
    for sigma in [0.602, 0.7, 0.8, 0.85, 1.0] {
        let [squared, linear] =
            [Spacing::Squared, Spacing::Linear].map(|spacing| error(sigma, spacing, Precision::U8));
        let fine = error(sigma, Spacing::Squared, Precision::U16);
        println!(
            "sigma {sigma}: squared {squared:.2}, linear {linear:.2}, squared 16 bits {fine:.2} of 256 levels"
        );
        // Narrower Gaussians fall too steeply in the squared distance. Wider ones end with a step on the sphere, so
        // the footprint falls vertically at its edge; spacing by squares has more entries there.
        assert_eq!(squared <= 2.0, [0.8, 0.85].contains(&sigma), "{sigma} {squared}");
        if sigma < 0.9 {
            // Half the difference of neighbours, exp(-u R^2 / 2 sigma^2) being steepest at u = 0, and half a level.
            let bound = 256.0 * (2.0 / sigma).powi(2) / 2.0 / 255.0 / 2.0;
            assert!(squared <= bound + 0.6 && fine <= bound + 0.05, "{squared} {fine}");
            assert!(linear < 2.0, "{linear}");
        }
    }
}

#[test]
fn errors_fall_with_the_entries() {
    for kernel in KERNELS {
        let error = |entries, precision| {
            let settings = TableSettings {
                entries,
                precision,
                sections: 1,
                spacing: Spacing::Squared,
            };
            largest_error(kernel, settings)
        };
        let errors = [32, 64, 128, 256, 512, 1024].map(|entries| error(entries, Precision::F32));
        println!(
            "{} f32, 32 to 1024 entries: {errors:.2?} of 256 levels",
            kernel.name()
        );
        for pair in errors.windows(2) {
            assert!(pair[1] < 0.6 * pair[0], "{errors:?}");
        }
        // 8 bits add half a level, 16 bits next to nothing.
        assert!(error(256, Precision::U8) < errors[3] + 0.51);
        assert!(error(256, Precision::U16) < errors[3] + 0.01);
    }
}

#[test]
fn sections_are_the_kernels_parts() {
    for kernel in KERNELS {
        let settings = TableSettings {
            entries: 1024,
            precision: Precision::F32,
            spacing: Spacing::Linear,
            sections: 128,
        };
        let (table, radial) = (table(kernel, settings), RadialKernel::new(kernel));
        let (support, peak) = (radial.support(), radial.line_integral(0.0));
        let mut largest = 0.0_f64;
        for i in 0..=200 {
            // Depths on rows, distances on entries: nothing is rounded.
            let rho = f64::from(i * 5) / 1023.0;
            let [front, back] = [i % 100 - 60, (i * 7) % 64].map(|row| f64::from(row) / 64.0);
            let part = |depth: f64| radial.partial_line_integral((rho * support).powi(2), depth * support);
            let exact = (part(back) - part(front)).max(0.0);
            let found = table.between((rho * rho) as f32, front as f32, back as f32);
            largest = largest.max((f64::from(found) - exact).abs() / peak);
        }
        assert!(largest < 2e-6, "{kernel:?} {largest}");
    }
}

#[test]
fn slabs_add_up_to_the_footprint_exactly() {
    for precision in [Precision::U8, Precision::U16] {
        let settings = TableSettings {
            precision,
            ..TableSettings::default()
        };
        for sections in [1, 128] {
            let table = table(Kernel::KAISER_BESSEL, TableSettings { sections, ..settings });
            let unit = table.value(0.0)
                / if precision == Precision::U8 {
                    255.0
                } else {
                    65535.0
                };
            for i in 0..50 {
                let rho2 = i as f32 / 50.0;
                let depths: Vec<f32> = (0..=17).map(|k| -1.3 + 2.6 * k as f32 / 17.0).collect();
                let sum: f32 = depths
                    .windows(2)
                    .map(|ends| table.between(rho2, ends[0], ends[1]) / unit)
                    .map(f32::round)
                    .sum();
                assert_eq!(sum, (table.value(rho2) / unit).round());
            }
        }
    }
}

#[test]
fn a_kernel_of_one_section_lies_where_its_centre_is() {
    let settings = TableSettings {
        sections: 1,
        ..TableSettings::default()
    };
    let table = table(Kernel::CubicBspline, settings);
    assert_eq!(table.between(0.1, -0.01, 0.01), table.value(0.1));
    assert_eq!(table.between(0.1, 0.01, 0.9), 0.0);
    assert_eq!(table.between(0.1, 0.9, -0.9), 0.0);
}

#[test]
fn every_number_has_an_answer() {
    for spacing in [Spacing::Linear, Spacing::Squared] {
        let settings = TableSettings {
            spacing,
            ..TableSettings::default()
        };
        let table = table(Kernel::CrawfisMax, settings);
        for rho2 in [1.0, 1.7, f32::INFINITY] {
            assert_eq!(table.value(rho2), 0.0);
        }
        for odd in [f32::NAN, f32::NEG_INFINITY, -3.0, f32::INFINITY] {
            assert!(table.value(odd).is_finite());
            assert!(table.between(0.5, odd, 1.0).is_finite() && table.between(0.5, -1.0, odd).is_finite());
        }
        let AnySection::U8(section) = table.section(-1.0, 0.0) else {
            panic!("8 bits were asked for")
        };
        assert_eq!(section.at(0.25), table.between(0.25, -1.0, 0.0));
        assert!(!section.is_empty());
    }
}

#[test]
fn settings_outside_their_domain_are_refused() {
    let refusal = |settings| {
        FootprintTable::new(Kernel::CrawfisMax, settings)
            .expect_err("refused")
            .to_string()
    };
    let settings = TableSettings::default();
    let few = refusal(TableSettings {
        entries: 31,
        ..settings
    });
    assert!(few.contains("footprint table entries: 31"), "{few}");
    let sections = refusal(TableSettings {
        sections: 129,
        ..settings
    });
    assert!(sections.contains("footprint table sections: 129"), "{sections}");
    let sigma = Kernel::Gaussian {
        sigma: 99.0,
        radius: 200.0,
    };
    assert!(FootprintTable::new(sigma, settings).is_err());
}
