//! Tables of results: columns as NumPy arrays and as an Arrow stream over the same memory.

use std::collections::HashMap;
use std::ffi::CStr;
use std::ptr::NonNull;
use std::sync::Arc;

use arcmin::results::{Cells, Table as Filled};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, RecordBatchIterator, StringArray};
use arrow_buffer::{Buffer, NullBuffer, ScalarBuffer};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use numpy::ndarray::ArrayView1;
use numpy::{Element, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyIterator, PyList};

const STREAM: &CStr = c"arrow_array_stream";

/// A table of results: one NumPy array for each column, with the unit at the end of its name.
///
/// ``table["force_n"]`` is a read-only array of shape (rows,) over the table's own memory. Missing numbers are
/// NaN. Any reader of Arrow imports the table without copying: ``polars.DataFrame(table)``,
/// ``pyarrow.table(table)``, ``pandas.DataFrame.from_arrow(table)``.
#[pyclass(module = "arcmin", frozen, mapping)]
pub struct Table {
    /// Name, which is that of its CSV file without the extension.
    #[pyo3(get)]
    name: String,
    /// Meaning of a row.
    #[pyo3(get)]
    what: String,
    columns: Arc<Vec<Column>>,
}

struct Column {
    key: String,
    unit: String,
    what: String,
    cells: Values,
}

enum Values {
    Numbers(Vec<f64>),
    Counts(Vec<i64>),
    Words(Vec<String>),
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Values::Numbers(numbers) => numbers.len(),
            Values::Counts(counts) => counts.len(),
            Values::Words(words) => words.len(),
        }
    }
}

impl Table {
    /// A table of the library; its numbers are moved, not copied.
    pub fn of(table: Filled) -> Table {
        let column = |column: arcmin::results::TableColumn| Column {
            key: column.quantity.key.to_owned(),
            unit: column.quantity.unit().to_owned(),
            what: column.quantity.what.to_owned(),
            cells: match column.cells {
                Cells::Numbers(numbers) => Values::Numbers(numbers),
                // No count comes near 2⁶³.
                Cells::Counts(counts) => {
                    Values::Counts(counts.into_iter().map(|count| count.cast_signed()).collect())
                }
                Cells::Words(words) => Values::Words(words),
            },
        };
        Table {
            name: table.name.to_owned(),
            what: table.what.to_owned(),
            columns: Arc::new(table.columns.into_iter().map(column).collect()),
        }
    }

    fn column(&self, key: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.key == key)
    }

    fn batch(&self) -> Result<RecordBatch, ArrowError> {
        let mut fields = Vec::new();
        let mut arrays: Vec<ArrayRef> = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            let (array, kind): (ArrayRef, DataType) = match &column.cells {
                Values::Numbers(numbers) => {
                    let there = numbers
                        .iter()
                        .any(|number| number.is_nan())
                        .then(|| numbers.iter().map(|number| !number.is_nan()).collect::<NullBuffer>());
                    (Arc::new(Float64Array::new(self.scalars(index), there)), DataType::Float64)
                }
                Values::Counts(_) => (Arc::new(Int64Array::new(self.scalars(index), None)), DataType::Int64),
                Values::Words(words) => (Arc::new(StringArray::from_iter_values(words)), DataType::Utf8),
            };
            let about = [("unit", &column.unit), ("description", &column.what)];
            let about = about.into_iter().filter(|(_, text)| !text.is_empty());
            let about: HashMap<String, String> =
                about.map(|(name, text)| (name.to_owned(), text.clone())).collect();
            fields.push(Field::new(&column.key, kind, true).with_metadata(about));
            arrays.push(array);
        }
        RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
    }

    /// The memory of a column of numbers or counts, which the buffer keeps alive.
    fn scalars<T: arrow_buffer::ArrowNativeType>(&self, index: usize) -> ScalarBuffer<T> {
        let (pointer, length) = match &self.columns[index].cells {
            Values::Numbers(numbers) => (numbers.as_ptr().cast::<u8>(), numbers.len()),
            Values::Counts(counts) => (counts.as_ptr().cast::<u8>(), counts.len()),
            Values::Words(_) => (NonNull::<u64>::dangling().as_ptr().cast_const().cast(), 0),
        };
        let Some(pointer) = NonNull::new(pointer.cast_mut()) else { return ScalarBuffer::from(Vec::new()) };
        // SAFETY: both kinds have eight bytes per entry; the vector is never changed and lives as long as the
        // owner that the buffer holds.
        let buffer = unsafe { Buffer::from_custom_allocation(pointer, length * 8, self.columns.clone()) };
        ScalarBuffer::new(buffer, 0, length)
    }
}

/// An array over `values`, whose memory `owner` keeps alive.
fn view<'py, T: Element>(owner: &Bound<'py, Table>, values: &[T]) -> Bound<'py, PyAny> {
    // SAFETY: the table is frozen: its vectors are neither changed nor moved during its life.
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner.clone().into_any()) };
    array.readwrite().make_nonwriteable().as_any().clone()
}

#[pymethods]
impl Table {
    /// A table of columns, each (name, unit, description, array or list of words).
    #[new]
    fn new(py: Python<'_>, name: String, what: String, columns: &Bound<'_, PyAny>) -> PyResult<Table> {
        let mut all = Vec::new();
        // One by one, because a lazy sequence may claim any length.
        for column in columns.try_iter()? {
            let (key, unit, what, values): (String, String, String, Bound<'_, PyAny>) = column?.extract()?;
            let kind: String = match values.getattr("dtype") {
                Ok(dtype) => dtype.getattr("kind")?.extract()?,
                Err(_) => String::new(),
            };
            let numpy = || py.import("numpy");
            let cells = match kind.as_str() {
                "f" => {
                    let array: PyReadonlyArray1<'_, f64> =
                        numpy()?.call_method1("ascontiguousarray", (&values, "f8"))?.extract()?;
                    Values::Numbers(array.as_slice()?.to_vec())
                }
                "i" | "u" => {
                    let array: PyReadonlyArray1<'_, i64> =
                        numpy()?.call_method1("ascontiguousarray", (&values, "i8"))?.extract()?;
                    Values::Counts(array.as_slice()?.to_vec())
                }
                _ => Values::Words(values.try_iter()?.map(|word| word?.extract()).collect::<PyResult<_>>()?),
            };
            all.push(Column { key, unit, what, cells });
        }
        if all.windows(2).any(|pair| pair[0].cells.len() != pair[1].cells.len()) {
            return Err(PyValueError::new_err("columns of a table must have equal lengths"));
        }
        Ok(Table { name, what, columns: Arc::new(all) })
    }

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let py = this.py();
        let table = this.get();
        let columns = PyList::empty(py);
        for column in table.columns.iter() {
            columns.append((&column.key, &column.unit, &column.what, Table::array(this, column)?))?;
        }
        let arguments = (&table.name, &table.what, columns).into_pyobject(py)?;
        Ok((py.get_type::<Table>().into_any(), arguments.into_any()))
    }

    /// Names of the columns.
    fn keys(&self) -> Vec<&str> {
        self.columns.iter().map(|column| column.key.as_str()).collect()
    }

    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.keys()
    }

    /// The arrays of all columns.
    fn values<'py>(this: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        this.get().columns.iter().map(|column| Table::array(this, column)).collect()
    }

    /// Names and arrays of all columns.
    fn items<'py>(this: &Bound<'py, Self>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let one = |column: &Column| Ok((column.key.clone(), Table::array(this, column)?));
        this.get().columns.iter().map(one).collect()
    }

    /// Units of the columns for readers; empty for numbers without unit, counts and words.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        for column in self.columns.iter() {
            units.set_item(&column.key, &column.unit)?;
        }
        Ok(units)
    }

    /// Meaning of the columns.
    #[getter]
    fn descriptions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for column in self.columns.iter() {
            all.set_item(&column.key, &column.what)?;
        }
        Ok(all)
    }

    /// Number of rows.
    #[getter]
    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// Number of rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.rows(), self.columns.len())
    }

    /// Number of columns, as for any mapping.
    fn __len__(&self) -> usize {
        self.columns.len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.keys())?.try_iter()
    }

    fn __contains__(&self, key: &Bound<'_, PyAny>) -> bool {
        key.extract::<&str>().is_ok_and(|key| self.column(key).is_some())
    }

    fn __getitem__<'py>(this: &Bound<'py, Self>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let table = this.get();
        let Some(column) = table.column(key) else {
            let names = table.keys().join(", ");
            let message = format!("{} has no column \"{key}\"; it has {names}", table.name);
            return Err(PyKeyError::new_err(message));
        };
        Table::array(this, column)
    }

    /// The array of a column, or a default if there is no such column.
    #[pyo3(signature = (key, default = None))]
    fn get<'py>(
        this: &Bound<'py, Self>,
        key: &str,
        default: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        match this.get().column(key) {
            Some(column) => Table::array(this, column),
            None => Ok(default.unwrap_or_else(|| this.py().None().into_bound(this.py()))),
        }
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let Ok(other) = other.cast::<Table>() else { return false };
        let other = other.get();
        let bits = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
        };
        let same = |a: &Values, b: &Values| match (a, b) {
            (Values::Numbers(a), Values::Numbers(b)) => bits(a, b),
            (Values::Counts(a), Values::Counts(b)) => a == b,
            (Values::Words(a), Values::Words(b)) => a == b,
            _ => false,
        };
        self.name == other.name
            && self.columns.len() == other.columns.len()
            && self
                .columns
                .iter()
                .zip(&*other.columns)
                .all(|(a, b)| a.key == b.key && same(&a.cells, &b.cells))
    }

    fn __repr__(&self) -> String {
        let (rows, columns) = self.shape();
        format!("<Table {}: {rows} rows of {columns} columns: {}>", self.name, self.keys().join(", "))
    }

    /// The Arrow PyCapsule interface: a stream of one batch. Missing numbers are null, fields contain unit and
    /// description.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // In the protocol other types are optional for the producer; they are not available here.
        drop(requested_schema);
        let batch = self.batch().map_err(|error| PyValueError::new_err(error.to_string()))?;
        let schema = batch.schema();
        let stream = FFI_ArrowArrayStream::new(Box::new(RecordBatchIterator::new([Ok(batch)], schema)));
        PyCapsule::new_with_value(py, stream, STREAM)
    }
}

impl Table {
    fn array<'py>(this: &Bound<'py, Self>, column: &Column) -> PyResult<Bound<'py, PyAny>> {
        match &column.cells {
            Values::Numbers(numbers) => Ok(view(this, numbers)),
            Values::Counts(counts) => Ok(view(this, counts)),
            Values::Words(words) => {
                let py = this.py();
                py.import("numpy")?.call_method1("array", (PyList::new(py, words)?, "U"))
            }
        }
    }
}
