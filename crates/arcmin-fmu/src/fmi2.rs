//! FMI 2.0, co-simulation.

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::PathBuf;
use std::ptr;

use arcmin::exchange::fmu::Kind;

use crate::instance::{Instance, Number, Phase, Refusal, SavedInstance, Status};
use crate::raw::{list, list_mut, text};

type Component = *mut Instance;
type State = *mut SavedInstance;

/// The logger takes a format and further arguments; our messages need none, so that the format contains no `%`.
type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger>,
    _allocate_memory: *const c_void,
    _free_memory: *const c_void,
    _step_finished: *const c_void,
    environment: *mut c_void,
}

const CO_SIMULATION: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Runs a call on an instance; a null pointer is an error.
unsafe fn on(c: Component, call: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> c_int {
    // SAFETY: the importer passes a pointer from `fmi2Instantiate`, and calls one function at a time.
    match unsafe { c.as_mut() } {
        Some(instance) => instance.answer(call) as c_int,
        None => Status::Error as c_int,
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: Component,
    on_: c_int,
    _: usize,
    _: *const *const c_char,
) -> c_int {
    unsafe {
        on(c, |instance| {
            instance.logging = on_ != 0;
            Ok(())
        })
    }
}

/// `file:///a%20b` and `file:/a` as paths.
pub fn path_of(location: &str) -> PathBuf {
    let rest = location.strip_prefix("file:").unwrap_or(location);
    let rest = match rest.strip_prefix("//") {
        // The text before the path is a host name, that of this machine.
        Some(after) => after.find('/').map_or(after, |slash| &after[slash..]),
        None => rest,
    };
    let bytes = rest.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let hex = (bytes[at] == b'%').then(|| rest.get(at + 1..at + 3)).flatten();
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                decoded.push(byte);
                at += 3;
            }
            None => {
                decoded.push(bytes[at]);
                at += 1;
            }
        }
    }
    PathBuf::from(String::from_utf8_lossy(&decoded).into_owned())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    functions: *const Callbacks,
    _visible: c_int,
    logging: c_int,
) -> Component {
    // SAFETY: texts and callbacks belong to the importer and are valid during this call.
    let (name, guid, resources) = unsafe { (text(name), text(guid), text(resources)) };
    let (logger, environment) = match unsafe { functions.as_ref() } {
        Some(functions) => (functions.logger, functions.environment),
        None => (None, ptr::null_mut()),
    };
    let own_name = CString::new(name.replace('\0', "")).unwrap_or_default();
    let log = Box::new(move |status: Status, message: &str| {
        let Some(logger) = logger else { return };
        let message = CString::new(message.replace('%', "%%").replace('\0', "")).unwrap_or_default();
        // SAFETY: by the standard the logger is valid as long as the instance.
        unsafe {
            logger(
                environment,
                own_name.as_ptr(),
                status as c_int,
                c"logStatusError".as_ptr(),
                message.as_ptr(),
            );
        }
    });
    if kind != CO_SIMULATION {
        log(Status::Error, "this unit offers co-simulation only");
        return ptr::null_mut();
    }
    match Instance::new(&guid, &path_of(&resources), logging != 0, log) {
        Some(instance) => Box::into_raw(Box::new(instance)),
        None => ptr::null_mut(),
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Component) {
    if !c.is_null() {
        // SAFETY: made by `Box::into_raw` above, freed once.
        drop(unsafe { Box::from_raw(c) });
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: Component,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    _stop_defined: c_int,
    _stop: f64,
) -> c_int {
    unsafe { on(c, |instance| instance.set_start(start)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: Component) -> c_int {
    unsafe { on(c, Instance::enter_initialisation) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: Component) -> c_int {
    unsafe { on(c, Instance::exit_initialisation) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: Component) -> c_int {
    unsafe { on(c, Instance::terminate) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Component) -> c_int {
    unsafe { on(c, Instance::reset) }
}

macro_rules! access {
    ($get:ident, $set:ident, $Type:ty, $kind:expr, $out:expr, $into:expr) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(c: Component, vr: *const c_uint, n: usize, value: *mut $Type) -> c_int {
            unsafe {
                on(c, |instance| {
                    instance.refresh()?;
                    for (vr, value) in list(vr, n).iter().zip(list_mut(value, n)) {
                        *value = $out(instance.get(*vr, $kind)?);
                    }
                    Ok(())
                })
            }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            c: Component,
            vr: *const c_uint,
            n: usize,
            value: *const $Type,
        ) -> c_int {
            unsafe {
                on(c, |instance| {
                    for (vr, value) in list(vr, n).iter().zip(list(value, n)) {
                        instance.set(*vr, $into(*value))?;
                    }
                    Ok(())
                })
            }
        }
    };
}

fn real(number: Number) -> f64 {
    match number {
        Number::Real(value) => value,
        Number::Integer(value) => value.into(),
        Number::Boolean(value) => f64::from(u8::from(value)),
    }
}

fn whole(number: Number) -> c_int {
    match number {
        Number::Integer(value) => value,
        Number::Boolean(value) => value.into(),
        Number::Real(_) => 0,
    }
}

access!(fmi2GetReal, fmi2SetReal, f64, Kind::Real, real, Number::Real);
access!(fmi2GetInteger, fmi2SetInteger, c_int, Kind::Integer, whole, Number::Integer);
access!(fmi2GetBoolean, fmi2SetBoolean, c_int, Kind::Boolean, whole, |value: c_int| Number::Boolean(
    value != 0
));

/// There are no texts: a request for none of them is valid.
unsafe fn no_texts(c: Component, n: usize) -> c_int {
    unsafe {
        on(c, |_| match n {
            0 => Ok(()),
            _ => Err(Refusal::error("this unit has no variables of type String")),
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: Component,
    _: *const c_uint,
    n: usize,
    _: *mut *const c_char,
) -> c_int {
    unsafe { no_texts(c, n) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: Component,
    _: *const c_uint,
    n: usize,
    _: *const *const c_char,
) -> c_int {
    unsafe { no_texts(c, n) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Component, state: *mut State) -> c_int {
    unsafe { on(c, |instance| save(instance, state)) }
}

/// Saves the state of an instance; an old state is overwritten, as required by the standard.
pub unsafe fn save(instance: &mut Instance, state: *mut State) -> Result<(), Refusal> {
    // SAFETY: the importer passes a pointer to a pointer that is null or an old state.
    unsafe {
        let Some(place) = state.as_mut() else { return Err(Refusal::error("no place for the state")) };
        match place.as_mut() {
            Some(old) => *old = instance.save(),
            None => *place = Box::into_raw(Box::new(instance.save())),
        }
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Component, state: State) -> c_int {
    unsafe { on(c, |instance| restore(instance, state)) }
}

pub unsafe fn restore(instance: &mut Instance, state: State) -> Result<(), Refusal> {
    // SAFETY: a state of ours or null.
    match unsafe { state.as_ref() } {
        Some(state) => instance.restore(state),
        None => Err(Refusal::error("there is no state")),
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: Component, state: *mut State) -> c_int {
    unsafe {
        on(c, |_| {
            free(state);
            Ok(())
        })
    }
}

pub unsafe fn free(state: *mut State) {
    // SAFETY: as in `save`; afterwards the pointer is null, so that freeing twice does no harm.
    unsafe {
        if let Some(place) = state.as_mut()
            && !place.is_null()
        {
            drop(Box::from_raw(*place));
            *place = ptr::null_mut();
        }
    }
}

pub unsafe fn bytes_of(state: State) -> Result<Vec<u8>, Refusal> {
    // SAFETY: a state of ours or null.
    match unsafe { state.as_ref() } {
        Some(state) => state.to_bytes(),
        None => Err(Refusal::error("there is no state")),
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: Component, state: State, size: *mut usize) -> c_int {
    unsafe {
        on(c, |_| {
            let bytes = bytes_of(state)?;
            list_mut(size, 1).iter_mut().for_each(|size| *size = bytes.len());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: Component,
    state: State,
    out: *mut u8,
    size: usize,
) -> c_int {
    unsafe { on(c, |_| write_bytes(state, out, size)) }
}

pub unsafe fn write_bytes(state: State, out: *mut u8, size: usize) -> Result<(), Refusal> {
    // SAFETY: the importer gives a place of that size.
    unsafe {
        let bytes = bytes_of(state)?;
        let out = list_mut(out, size);
        if out.len() < bytes.len() {
            return Err(Refusal::error(format!(
                "the state has {} bytes, the place {}",
                bytes.len(),
                out.len()
            )));
        }
        out[..bytes.len()].copy_from_slice(&bytes);
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: Component,
    bytes: *const u8,
    size: usize,
    state: *mut State,
) -> c_int {
    unsafe { on(c, |_| read_bytes(bytes, size, state)) }
}

pub unsafe fn read_bytes(bytes: *const u8, size: usize, state: *mut State) -> Result<(), Refusal> {
    // SAFETY: the importer passes the bytes of `write_bytes`; other bytes are refused when read.
    unsafe {
        let saved = SavedInstance::from_bytes(list(bytes, size))?;
        let Some(place) = state.as_mut() else { return Err(Refusal::error("no place for the state")) };
        *place = Box::into_raw(Box::new(saved));
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: Component,
    _: *const c_uint,
    _: usize,
    _: *const c_uint,
    _: usize,
    _: *const f64,
    _: *mut f64,
) -> c_int {
    unsafe { on(c, |_| Err(Refusal::error("this unit has no directional derivatives"))) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: Component,
    vr: *const c_uint,
    n: usize,
    order: *const c_int,
    value: *const f64,
) -> c_int {
    unsafe {
        on(c, |instance| {
            for ((vr, order), value) in list(vr, n).iter().zip(list(order, n)).zip(list(value, n)) {
                instance.set_derivative(*vr, *order, *value)?;
            }
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: Component,
    _: *const c_uint,
    n: usize,
    _: *const c_int,
    _: *mut f64,
) -> c_int {
    unsafe {
        on(c, |_| match n {
            0 => Ok(()),
            _ => Err(Refusal::error("this unit has no derivatives of outputs")),
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(c: Component, from: f64, length: f64, _: c_int) -> c_int {
    unsafe { on(c, |instance| instance.step(from, length)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: Component) -> c_int {
    unsafe { on(c, |_| Err(Refusal::error("steps are never pending"))) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: Component, _: c_int, _: *mut c_int) -> c_int {
    unsafe { on(c, |_| Err(Refusal::discard("steps are never pending"))) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Component, kind: c_int, value: *mut f64) -> c_int {
    unsafe {
        on(c, |instance| {
            if kind != LAST_SUCCESSFUL_TIME {
                return Err(Refusal::discard("there is no such status"));
            }
            let time = instance.time();
            list_mut(value, 1).iter_mut().for_each(|value| *value = time);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: Component, _: c_int, _: *mut c_int) -> c_int {
    unsafe { on(c, |_| Err(Refusal::discard("there is no such status"))) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut c_int) -> c_int {
    unsafe {
        on(c, |instance| {
            if kind != TERMINATED {
                return Err(Refusal::discard("there is no such status"));
            }
            let terminated = instance.phase() == Phase::Terminated;
            list_mut(value, 1).iter_mut().for_each(|value| *value = terminated.into());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: Component, _: c_int, _: *mut *const c_char) -> c_int {
    unsafe { on(c, |_| Err(Refusal::discard("there is no such status"))) }
}
