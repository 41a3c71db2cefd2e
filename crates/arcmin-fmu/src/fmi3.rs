//! FMI 3.0, co-simulation; functions of the other kinds of units report that they are not available.

use std::ffi::{CString, c_char, c_int, c_void};
use std::path::PathBuf;
use std::ptr;

use arcmin::exchange::fmu::Kind;

use crate::fmi2;
use crate::instance::{Instance, Number, Refusal, SavedInstance, Status};
use crate::raw::{list, list_mut, text};

type State = *mut SavedInstance;
type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// Runs a call on an instance; a null pointer is an error.
unsafe fn on(instance: *mut Instance, call: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> c_int {
    // SAFETY: the importer passes a pointer from an instantiating function, and calls one function at a time.
    match unsafe { instance.as_mut() } {
        Some(instance) => instance.answer(call) as c_int,
        None => Status::Error as c_int,
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut Instance,
    logging: bool,
    _: usize,
    _: *const *const c_char,
) -> c_int {
    unsafe {
        on(instance, |instance| {
            instance.logging = logging;
            Ok(())
        })
    }
}

fn log(environment: *mut c_void, message: Option<LogMessage>) -> Box<dyn Fn(Status, &str)> {
    Box::new(move |status: Status, text: &str| {
        let Some(message) = message else { return };
        let text = CString::new(text.replace('\0', "")).unwrap_or_default();
        // SAFETY: by the standard the callback is valid as long as the instance.
        unsafe { message(environment, status as c_int, c"logStatusError".as_ptr(), text.as_ptr()) };
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    logging: bool,
    _event_mode_used: bool,
    _early_return_allowed: bool,
    _intermediate: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _update: *const c_void,
) -> *mut Instance {
    // SAFETY: texts belong to the importer and are valid during this call.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    match Instance::new(&token, &PathBuf::from(resources), logging, log(environment, message)) {
        Some(instance) => Box::into_raw(Box::new(instance)),
        None => ptr::null_mut(),
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: Option<LogMessage>,
) -> *mut Instance {
    log(environment, message)(Status::Error, "this unit offers co-simulation only");
    ptr::null_mut()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> *mut Instance {
    log(environment, message)(Status::Error, "this unit offers co-simulation only");
    ptr::null_mut()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut Instance) {
    // SAFETY: as in FMI 2.
    unsafe { fmi2::fmi2FreeInstance(instance) };
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut Instance,
    _tolerance_defined: bool,
    _tolerance: f64,
    start: f64,
    _stop_defined: bool,
    _stop: f64,
) -> c_int {
    unsafe {
        on(instance, |instance| {
            instance.set_start(start)?;
            instance.enter_initialisation()
        })
    }
}

/// Calls without arguments.
macro_rules! calls {
    ($($name:ident => $call:expr;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut Instance) -> c_int {
            unsafe { on(instance, $call) }
        }
    )*};
}

/// Refuses a function that is not available in this unit.
fn missing(what: &str) -> Result<(), Refusal> {
    Err(Refusal::error(format!("this unit has no {what}")))
}

calls! {
    fmi3ExitInitializationMode => Instance::exit_initialisation;
    fmi3Terminate => Instance::terminate;
    fmi3Reset => Instance::reset;
    fmi3EnterConfigurationMode => |instance| instance.configure(true);
    fmi3ExitConfigurationMode => |instance| instance.configure(false);
    fmi3EnterEventMode => |_| missing("event mode");
    fmi3EnterStepMode => |_| missing("event mode to leave");
    fmi3EvaluateDiscreteStates => |_| missing("discrete states");
    fmi3EnterContinuousTimeMode => |_| missing("continuous-time mode");
}

macro_rules! access {
    ($get:ident, $set:ident, $Type:ty, $kind:expr, $out:expr, $into:expr) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut Instance,
            references: *const u32,
            count: usize,
            values: *mut $Type,
            value_count: usize,
        ) -> c_int {
            unsafe {
                on(instance, |instance| {
                    same(count, value_count)?;
                    instance.refresh()?;
                    for (reference, value) in list(references, count).iter().zip(list_mut(values, count)) {
                        *value = $out(instance.get(*reference, $kind)?);
                    }
                    Ok(())
                })
            }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut Instance,
            references: *const u32,
            count: usize,
            values: *const $Type,
            value_count: usize,
        ) -> c_int {
            unsafe {
                on(instance, |instance| {
                    same(count, value_count)?;
                    for (reference, value) in list(references, count).iter().zip(list(values, count)) {
                        instance.set(*reference, $into(*value))?;
                    }
                    Ok(())
                })
            }
        }
    };
}

/// Every variable is a scalar.
fn same(count: usize, value_count: usize) -> Result<(), Refusal> {
    if count == value_count {
        return Ok(());
    }
    Err(Refusal::error(format!("{count} scalars have {count} values, not {value_count}")))
}

fn real(number: Number) -> f64 {
    if let Number::Real(value) = number { value } else { 0.0 }
}

fn whole(number: Number) -> i32 {
    if let Number::Integer(value) = number { value } else { 0 }
}

access!(fmi3GetFloat64, fmi3SetFloat64, f64, Kind::Real, real, Number::Real);
access!(fmi3GetInt32, fmi3SetInt32, i32, Kind::Integer, whole, Number::Integer);
access!(
    fmi3GetBoolean,
    fmi3SetBoolean,
    bool,
    Kind::Boolean,
    |n: Number| n == Number::Boolean(true),
    Number::Boolean
);

/// Types without variables: a request for none of them is valid.
macro_rules! types_without_variables {
    ($($get:ident $set:ident $Type:ty;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut Instance, _: *const u32, count: usize, _: *mut $Type, _: usize,
        ) -> c_int {
            unsafe { on(instance, |_| if count == 0 { Ok(()) } else { missing("variables of this type") }) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut Instance, _: *const u32, count: usize, _: *const $Type, _: usize,
        ) -> c_int {
            unsafe { on(instance, |_| if count == 0 { Ok(()) } else { missing("variables of this type") }) }
        }
    )*};
}

types_without_variables! {
    fmi3GetFloat32 fmi3SetFloat32 f32;
    fmi3GetInt8 fmi3SetInt8 i8;
    fmi3GetUInt8 fmi3SetUInt8 u8;
    fmi3GetInt16 fmi3SetInt16 i16;
    fmi3GetUInt16 fmi3SetUInt16 u16;
    fmi3GetUInt32 fmi3SetUInt32 u32;
    fmi3GetInt64 fmi3SetInt64 i64;
    fmi3GetUInt64 fmi3SetUInt64 u64;
    fmi3GetString fmi3SetString *const c_char;
}

/// Functions that are not available in this unit, with their arguments; those about variables are valid for an empty
/// list.
macro_rules! absent {
    ($($name:ident($($argument:ident: $Type:ty),*) without $what:literal $(if $count:ident)?;)*) => {$(
        #[unsafe(no_mangle)]
        #[allow(unused_variables)]
        pub unsafe extern "C" fn $name(instance: *mut Instance, $($argument: $Type),*) -> c_int {
            $(if $count == 0 {
                return unsafe { on(instance, |_| Ok(())) };
            })?
            unsafe { on(instance, |_| missing($what)) }
        }
    )*};
}

absent! {
    fmi3GetBinary(v: *const u32, n: usize, sizes: *mut usize, values: *mut *const u8, m: usize)
        without "variables of type Binary" if n;
    fmi3SetBinary(v: *const u32, n: usize, sizes: *const usize, values: *const *const u8, m: usize)
        without "variables of type Binary" if n;
    fmi3GetClock(v: *const u32, n: usize, values: *mut bool) without "clocks" if n;
    fmi3SetClock(v: *const u32, n: usize, values: *const bool) without "clocks" if n;
    fmi3GetDirectionalDerivative(u: *const u32, nu: usize, k: *const u32, nk: usize, seed: *const f64, ns: usize,
        sensitivity: *mut f64, m: usize) without "directional derivatives";
    fmi3GetAdjointDerivative(u: *const u32, nu: usize, k: *const u32, nk: usize, seed: *const f64, ns: usize,
        sensitivity: *mut f64, m: usize) without "adjoint derivatives";
    fmi3GetIntervalDecimal(v: *const u32, n: usize, intervals: *mut f64, qualifiers: *mut c_int)
        without "clocks" if n;
    fmi3GetIntervalFraction(v: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64,
        qualifiers: *mut c_int) without "clocks" if n;
    fmi3GetShiftDecimal(v: *const u32, n: usize, shifts: *mut f64) without "clocks" if n;
    fmi3GetShiftFraction(v: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64)
        without "clocks" if n;
    fmi3SetIntervalDecimal(v: *const u32, n: usize, intervals: *const f64) without "clocks" if n;
    fmi3SetIntervalFraction(v: *const u32, n: usize, counters: *const u64, resolutions: *const u64)
        without "clocks" if n;
    fmi3SetShiftDecimal(v: *const u32, n: usize, shifts: *const f64) without "clocks" if n;
    fmi3SetShiftFraction(v: *const u32, n: usize, counters: *const u64, resolutions: *const u64)
        without "clocks" if n;
    fmi3UpdateDiscreteStates(a: *mut bool, b: *mut bool, c: *mut bool, d: *mut bool, e: *mut bool, f: *mut f64)
        without "discrete states";
    fmi3CompletedIntegratorStep(a: bool, b: *mut bool, c: *mut bool) without "continuous-time mode";
    fmi3SetTime(time: f64) without "continuous-time mode";
    fmi3SetContinuousStates(x: *const f64, n: usize) without "continuous states" if n;
    fmi3GetContinuousStateDerivatives(x: *mut f64, n: usize) without "continuous states" if n;
    fmi3GetEventIndicators(x: *mut f64, n: usize) without "event indicators" if n;
    fmi3GetContinuousStates(x: *mut f64, n: usize) without "continuous states" if n;
    fmi3GetNominalsOfContinuousStates(x: *mut f64, n: usize) without "continuous states" if n;
    fmi3GetOutputDerivatives(v: *const u32, n: usize, orders: *const i32, values: *mut f64, m: usize)
        without "derivatives of outputs" if n;
    fmi3ActivateModelPartition(clock: u32, time: f64) without "clocks";
    fmi3GetVariableDependencies(dependent: u32, elements: *mut usize, independents: *mut u32, of: *mut usize,
        kinds: *mut c_int, n: usize) without "dependencies beside those of its description" if n;
}

/// Functions that return a count: zero.
macro_rules! none_of {
    ($($name:ident($($argument:ident: $Type:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        #[allow(unused_variables)]
        pub unsafe extern "C" fn $name(instance: *mut Instance, $($argument: $Type,)* count: *mut usize) -> c_int {
            unsafe {
                on(instance, |_| {
                    list_mut(count, 1).iter_mut().for_each(|count| *count = 0);
                    Ok(())
                })
            }
        }
    )*};
}

none_of! {
    fmi3GetNumberOfEventIndicators();
    fmi3GetNumberOfContinuousStates();
    fmi3GetNumberOfVariableDependencies(reference: u32);
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut Instance, state: *mut State) -> c_int {
    unsafe { on(instance, |instance| fmi2::save(instance, state)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut Instance, state: State) -> c_int {
    unsafe { on(instance, |instance| fmi2::restore(instance, state)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: *mut Instance, state: *mut State) -> c_int {
    unsafe {
        on(instance, |_| {
            fmi2::free(state);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut Instance,
    state: State,
    size: *mut usize,
) -> c_int {
    // SAFETY: as in FMI 2.
    unsafe { fmi2::fmi2SerializedFMUstateSize(instance, state, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut Instance,
    state: State,
    out: *mut u8,
    size: usize,
) -> c_int {
    unsafe { on(instance, |_| fmi2::write_bytes(state, out, size)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut Instance,
    bytes: *const u8,
    size: usize,
    state: *mut State,
) -> c_int {
    unsafe { on(instance, |_| fmi2::read_bytes(bytes, size, state)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut Instance,
    from: f64,
    length: f64,
    _no_set_state_before: bool,
    event: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    last_successful: *mut f64,
) -> c_int {
    unsafe {
        for flag in [event, terminate, early] {
            list_mut(flag, 1).iter_mut().for_each(|flag| *flag = false);
        }
        let status = on(instance, |instance| instance.step(from, length));
        if let Some(instance) = instance.as_ref() {
            let time = instance.time();
            list_mut(last_successful, 1).iter_mut().for_each(|last| *last = time);
        }
        status
    }
}
