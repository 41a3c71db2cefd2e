use std::ffi::{CString, c_char, c_int, c_void};
use std::path::PathBuf;
use std::ptr;

use arcmin::exchange::fmu::{Depth, LoadFlange, UnitData, references as r};

use crate::fmi2;
use crate::fmi3::*;
use crate::instance::Instance;

const TOKEN: &str = "{test}";

/// Resources of a multibody unit in ideal joints.
fn resources(name: &str) -> PathBuf {
    let directory = std::env::temp_dir().join(format!("arcmin-fmu-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let unit = UnitData {
        depth: Depth::Multibody,
        load_flange: LoadFlange::Torque,
        instantiation_token: TOKEN.into(),
        fidelity: "joints = \"ideal\"\n".into(),
        hours: [0.0, 1e7],
        start_hours: 0.0,
        start_seed: 0,
        joint: None,
        pins: Vec::new(),
    };
    std::fs::write(directory.join("unit.json"), serde_json::to_string(&unit).unwrap()).unwrap();
    std::fs::write(directory.join("design.toml"), arcmin::templates::TAO2024.text).unwrap();
    directory
}

unsafe extern "C" fn quiet(_: *mut c_void, _: c_int, _: *const c_char, _: *const c_char) {}

fn instantiate(directory: &std::path::Path, token: &str) -> *mut Instance {
    let (token, path) = (CString::new(token).unwrap(), CString::new(directory.to_str().unwrap()).unwrap());
    unsafe {
        fmi3InstantiateCoSimulation(
            c"test".as_ptr(),
            token.as_ptr(),
            path.as_ptr(),
            false,
            false,
            false,
            false,
            ptr::null(),
            0,
            ptr::null_mut(),
            Some(quiet),
            ptr::null(),
        )
    }
}

fn set(instance: *mut Instance, reference: u32, value: f64) -> c_int {
    unsafe { fmi3SetFloat64(instance, &reference, 1, &value, 1) }
}

fn get(instance: *mut Instance, reference: u32) -> f64 {
    let mut value = f64::NAN;
    assert_eq!(unsafe { fmi3GetFloat64(instance, &reference, 1, &mut value, 1) }, 0);
    value
}

fn step(instance: *mut Instance, from: f64, length: f64) -> c_int {
    let (mut a, mut b, mut c, mut last) = (false, false, false, 0.0);
    unsafe { fmi3DoStep(instance, from, length, true, &mut a, &mut b, &mut c, &mut last) }
}

fn initialised(directory: &std::path::Path) -> *mut Instance {
    let instance = instantiate(directory, TOKEN);
    assert!(!instance.is_null());
    assert_eq!(set(instance, r::B_TAU, -200.0), 0);
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), 0);
        assert_eq!(fmi3ExitInitializationMode(instance), 0);
    }
    instance
}

/// Turns at increasing speed for some steps from a step on; the transmission error after each, as bits.
fn course(instance: *mut Instance, steps: std::ops::Range<usize>) -> Vec<u64> {
    let h = 1e-3;
    steps
        .map(|k| {
            let t = h * k as f64;
            set(instance, r::A_PHI, 500.0 * t * t);
            set(instance, r::A_W, 1000.0 * t);
            set(instance, r::A_A, 1000.0);
            assert_eq!(step(instance, t, h), 0);
            get(instance, r::TRANSMISSION_ERROR).to_bits()
        })
        .collect()
}

/// Saved, restored, and transferred as bytes into another instance: every bit of the following results is the
/// same.
#[test]
fn saved_states_go_on_to_the_bit() {
    let directory = resources("save");
    let (first, second) = (initialised(&directory), instantiate(&directory, TOKEN));
    course(first, 0..5);
    let mut state = ptr::null_mut();
    unsafe { assert_eq!(fmi3GetFMUState(first, &mut state), 0) };
    let truth = course(first, 5..12);
    unsafe {
        assert_eq!(fmi3SetFMUState(first, state), 0);
        assert_eq!(course(first, 5..12), truth);
        let mut size = 0;
        assert_eq!(fmi3SerializedFMUStateSize(first, state, &mut size), 0);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(first, state, bytes.as_mut_ptr(), size), 0);
        let mut other = ptr::null_mut();
        assert_eq!(fmi3DeserializeFMUState(second, bytes.as_ptr(), size, &mut other), 0);
        assert_eq!(fmi3SetFMUState(second, other), 0);
        assert_eq!(course(second, 5..12), truth);
        assert_eq!(fmi3FreeFMUState(first, &mut state), 0);
        assert_eq!(fmi3FreeFMUState(first, &mut state), 0);
        assert_eq!(fmi3FreeFMUState(second, &mut other), 0);
        // Bytes that are not a state.
        assert_eq!(fmi3DeserializeFMUState(second, [1u8, 2, 3].as_ptr(), 3, &mut other), 3);
        fmi3FreeInstance(first);
        fmi3FreeInstance(second);
    }
    std::fs::remove_dir_all(directory).unwrap();
}

/// The load's torque is held at the start: the error equals that of the static solution, and is negative (lag).
#[test]
fn the_start_is_in_balance() {
    let directory = resources("start");
    let instance = initialised(&directory);
    let before = get(instance, r::TRANSMISSION_ERROR);
    assert!(before < 0.0, "{before}");
    for k in 0..20 {
        assert_eq!(step(instance, 1e-3 * f64::from(k), 1e-3), 0);
    }
    assert!((get(instance, r::TRANSMISSION_ERROR) - before).abs() < 1e-9);
    unsafe { fmi3FreeInstance(instance) };
    std::fs::remove_dir_all(directory).unwrap();
}

/// Invalid calls are refused, and the instance remains usable.
#[test]
fn wrong_calls_are_refused() {
    let directory = resources("wrong");
    assert!(instantiate(&directory, "{other}").is_null());
    assert!(instantiate(&directory.join("nowhere"), TOKEN).is_null());
    let instance = initialised(&directory);
    assert_eq!(set(instance, r::HOURS, 5.0), 3);
    assert_eq!(set(instance, r::TRANSMISSION_ERROR, 5.0), 3);
    assert_eq!(set(instance, r::A_W, f64::NAN), 3);
    assert_eq!(set(instance, 999, 0.0), 3);
    assert_eq!(step(instance, 0.5, 1e-3), 3);
    assert_eq!(step(instance, 0.0, -1.0), 3);
    assert_eq!(step(instance, 0.0, f64::NAN), 3);
    assert_eq!(step(ptr::null_mut(), 0.0, 1e-3), 3);
    assert_eq!(step(instance, 0.0, 1e-3), 0);
    unsafe {
        assert_eq!(fmi3EnterEventMode(instance), 3);
        assert_eq!(fmi3Terminate(instance), 0);
        assert_eq!(fmi3Reset(instance), 0);
        fmi3FreeInstance(instance);
    }
    std::fs::remove_dir_all(directory).unwrap();
}

#[test]
fn locations_become_paths() {
    for (location, path) in [
        ("file:///a/b%20c", "/a/b c"),
        ("file:/a/b", "/a/b"),
        ("file://localhost/a", "/a"),
        ("/a/%zz", "/a/%zz"),
        ("file:///100%", "/100%"),
    ] {
        assert_eq!(fmi2::path_of(location), PathBuf::from(path), "{location}");
    }
}

/// The default of the local error is that of the command, and an invalid one is refused when the model is
/// created.
#[test]
fn the_local_error_is_that_of_the_command() {
    let directory = resources("error");
    let instance = instantiate(&directory, TOKEN);
    let start = 5e-5 * std::f64::consts::PI / 180.0 / 60.0;
    assert!((get(instance, r::LOCAL_ERROR) / start - 1.0).abs() < 1e-12);
    assert_eq!(set(instance, r::LOCAL_ERROR, 1.0), 0);
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), 0);
        assert_eq!(fmi3ExitInitializationMode(instance), 3);
        fmi3FreeInstance(instance);
    }
    std::fs::remove_dir_all(directory).unwrap();
}

/// Values that an importer writes to `flange_a.a` and their use, compared with none: zeros, and accelerations
/// that are disabled, have no effect; enabled ones have.
#[test]
fn missing_accelerations_follow_from_the_speed() {
    let directory = resources("acceleration");
    let course = |used: bool, written: Option<f64>| {
        let instance = instantiate(&directory, TOKEN);
        let (on, reference) = (used, r::USE_ACCELERATION);
        unsafe {
            assert_eq!(fmi3SetBoolean(instance, &reference, 1, &on, 1), 0);
            assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), 0);
            assert_eq!(fmi3ExitInitializationMode(instance), 0);
        }
        let h = 1e-3;
        for k in 0..6 {
            let t = h * f64::from(k);
            set(instance, r::A_PHI, 500.0 * t * t);
            set(instance, r::A_W, 1000.0 * t);
            if let Some(value) = written {
                set(instance, r::A_A, value);
            }
            assert_eq!(step(instance, t, h), 0);
        }
        let found = get(instance, r::TRANSMISSION_ERROR).to_bits();
        unsafe { fmi3FreeInstance(instance) };
        found
    };
    let nothing = course(true, None);
    assert_eq!(course(true, Some(0.0)), nothing);
    assert_eq!(course(false, Some(0.0)), nothing);
    assert_eq!(course(false, Some(1000.0)), nothing);
    assert_ne!(course(true, Some(1000.0)), nothing);
    std::fs::remove_dir_all(directory).unwrap();
}
