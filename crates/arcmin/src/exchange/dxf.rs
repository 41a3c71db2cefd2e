//! DXF R2000 (AC1015): the smallest file with everything that the release requires.

use super::profile::ProfileExport;
use super::spline::CubicSpline;
use super::{millimetres, trimmed};
use crate::geometry::{Outline, Segment, Vec2, unit};

/// Representation of the flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contour {
    /// Chords within the tolerance.
    Polyline,
    /// A cubic spline.
    Spline,
    /// Both, for comparison.
    Both,
}

impl Contour {
    fn polyline(self) -> bool {
        self != Contour::Spline
    }

    fn spline(self) -> bool {
        self != Contour::Polyline
    }
}

struct Writer {
    text: String,
    handle: u32,
}

const MODEL_SPACE: &str = "1F";

impl Writer {
    fn put(&mut self, code: u16, value: &str) {
        self.text.push_str(&format!("{code:>3}\n{value}\n"));
    }

    fn put_all(&mut self, pairs: &[(u16, &str)]) {
        pairs.iter().for_each(|(code, value)| self.put(*code, value));
    }

    fn next_handle(&mut self) -> String {
        self.handle += 1;
        format!("{:X}", self.handle)
    }

    fn point(&mut self, place: Vec2) {
        self.put(10, &millimetres(place.x));
        self.put(20, &millimetres(place.y));
    }

    fn entity(&mut self, kind: &str, layer: &str, class: &str) {
        let handle = self.next_handle();
        self.put_all(&[
            (0, kind),
            (5, &handle),
            (330, MODEL_SPACE),
            (100, "AcDbEntity"),
            (8, layer),
            (100, class),
        ]);
    }

    fn circle(&mut self, layer: &str, centre: Vec2, radius: f64) {
        self.entity("CIRCLE", layer, "AcDbCircle");
        self.point(centre);
        self.put(30, "0");
        self.put(40, &millimetres(radius));
    }

    fn polyline(&mut self, layer: &str, corners: &[Vec2]) {
        self.entity("LWPOLYLINE", layer, "AcDbPolyline");
        self.put(90, &corners.len().to_string());
        self.put_all(&[(70, "1"), (43, "0")]);
        corners.iter().for_each(|corner| self.point(*corner));
    }

    /// A closed curve of lines and arcs; the bulge of an arc is the tangent of a quarter of its angle.
    fn outline(&mut self, layer: &str, outline: &Outline) {
        self.entity("LWPOLYLINE", layer, "AcDbPolyline");
        self.put(90, &outline.segments.len().to_string());
        self.put_all(&[(70, "1"), (43, "0")]);
        for segment in &outline.segments {
            self.point(segment.point(0.0));
            if let Segment::Arc { sweep, .. } = segment {
                self.put(42, &trimmed((0.25 * sweep).tan(), 12));
            }
        }
    }

    fn spline(&mut self, layer: &str, spline: &CubicSpline) {
        self.entity("SPLINE", layer, "AcDbSpline");
        let knots = spline.flat_knots();
        self.put_all(&[(210, "0"), (220, "0"), (230, "1")]);
        // Planar, and not flagged as closed, although it ends where it begins: some readers take a closed one
        // as periodic without clamped knots (LibreCAD), or do not display it (CadQuery).
        self.put_all(&[(70, "8"), (71, "3"), (72, &knots.len().to_string())]);
        self.put_all(&[(73, &spline.control.len().to_string()), (74, "0"), (42, "1e-9"), (43, "1e-9")]);
        knots.iter().for_each(|knot| self.put(40, &millimetres(*knot)));
        for control in &spline.control {
            self.point(*control);
            self.put(30, "0");
        }
    }

    fn text(&mut self, layer: &str, place: Vec2, height: f64, words: &str) {
        self.entity("TEXT", layer, "AcDbText");
        self.point(place);
        self.put(30, "0");
        self.put(40, &millimetres(height));
        self.put(1, &escaped(words));
        self.put(100, "AcDbText");
    }

    fn line(&mut self, layer: &str, from: Vec2, to: Vec2) {
        self.entity("LINE", layer, "AcDbLine");
        self.point(from);
        self.put(30, "0");
        self.put_all(&[(11, &millimetres(to.x)), (21, &millimetres(to.y)), (31, "0")]);
    }

    fn table(&mut self, name: &str, handle: &str, entries: usize, body: impl FnOnce(&mut Writer)) {
        self.put_all(&[(0, "TABLE"), (2, name), (5, handle), (330, "0"), (100, "AcDbSymbolTable")]);
        self.put(70, &entries.to_string());
        body(self);
        self.put(0, "ENDTAB");
    }

    fn record(&mut self, kind: &str, handle: &str, table: &str, class: &str, pairs: &[(u16, &str)]) {
        self.put_all(&[(0, kind), (5, handle), (330, table), (100, "AcDbSymbolTableRecord"), (100, class)]);
        self.put_all(pairs);
    }
}

/// Escapes for characters outside of ASCII in R2000, without control characters.
fn escaped(words: &str) -> String {
    words
        .chars()
        .filter(|c| !c.is_control())
        .flat_map(|c| if c.is_ascii() { vec![c] } else { format!("\\U+{:04X}", c as u32).chars().collect() })
        .collect()
}

impl ProfileExport {
    /// Drawing in DXF R2000, millimetres.
    ///
    /// Layers: FLANK_POLYLINE (closed LWPOLYLINE), FLANK_SPLINE (one cubic SPLINE that ends where it begins,
    /// with continuous tangent everywhere and continuous curvature except at roots and crests), DISC_n_BORES,
    /// DISC_n_HOLES, DISC_n_WINDOWS and DISC_n_MARK for every disc (the mark points to its first crank bore),
    /// PIN_RING about its own centre (RING, opening and outside, if it is one part), STAMP. The drawing of a
    /// single disc is for cutting and contains contours only, without mark, ring or text; the stamp is in its
    /// comments.
    pub fn dxf(&self, contour: Contour) -> String {
        let mut layers: Vec<(String, u8)> = vec![("0".into(), 7)];
        layers.extend(contour.polyline().then(|| ("FLANK_POLYLINE".into(), 7)));
        layers.extend(contour.spline().then(|| ("FLANK_SPLINE".into(), 5)));
        let kinds = [("BORES", 3), ("HOLES", 4), ("WINDOWS", 2)];
        for disc in self.discs() {
            layers.extend(kinds.map(|(kind, colour)| (format!("DISC_{}_{kind}", disc + 1), colour)));
            layers.extend(self.is_explained().then(|| (format!("DISC_{}_MARK", disc + 1), 1)));
        }
        if self.is_explained() {
            let ring = if self.contour().is_ok() { "RING" } else { "PIN_RING" };
            layers.extend([(ring.into(), 6), ("STAMP".into(), 8)]);
        }

        let mut w = Writer { text: String::new(), handle: 0x100 };
        self.entities(&mut w, contour);
        let (entities, last) = (std::mem::take(&mut w.text), w.handle);

        for stamp in self.stamps() {
            w.put(999, &escaped(&stamp));
        }
        let reach = millimetres(self.reach());
        let (seed, low) = (format!("{:X}", last + 0x400), format!("-{reach}"));
        w.put_all(&[(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015")]);
        w.put_all(&[(9, "$DWGCODEPAGE"), (3, "ANSI_1252"), (9, "$HANDSEED"), (5, &seed)]);
        w.put_all(&[(9, "$INSUNITS"), (70, "4"), (9, "$MEASUREMENT"), (70, "1")]);
        w.put_all(&[(9, "$EXTMIN"), (10, &low), (20, &low), (30, "0")]);
        w.put_all(&[(9, "$EXTMAX"), (10, &reach), (20, &reach), (30, "0"), (0, "ENDSEC")]);
        w.put_all(&[(0, "SECTION"), (2, "CLASSES"), (0, "ENDSEC")]);
        self.tables(&mut w, &layers);
        w.put_all(&[(0, "SECTION"), (2, "BLOCKS")]);
        for (name, owner, begin, end) in
            [("*Model_Space", "1F", "20", "21"), ("*Paper_Space", "1B", "1C", "1D")]
        {
            let head = [(0, "BLOCK"), (5, begin), (330, owner), (100, "AcDbEntity"), (8, "0")];
            w.put_all(&head);
            w.put_all(&[(100, "AcDbBlockBegin"), (2, name), (70, "0"), (10, "0"), (20, "0"), (30, "0")]);
            w.put_all(&[(3, name), (1, "")]);
            w.put_all(&[
                (0, "ENDBLK"),
                (5, end),
                (330, owner),
                (100, "AcDbEntity"),
                (8, "0"),
                (100, "AcDbBlockEnd"),
            ]);
        }
        w.put_all(&[(0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]);
        w.text.push_str(&entities);
        w.put_all(&[(0, "ENDSEC"), (0, "SECTION"), (2, "OBJECTS")]);
        w.put_all(&[(0, "DICTIONARY"), (5, "C"), (330, "0"), (100, "AcDbDictionary"), (281, "1")]);
        w.put_all(&[(3, "ACAD_GROUP"), (350, "D")]);
        w.put_all(&[(0, "DICTIONARY"), (5, "D"), (330, "C"), (100, "AcDbDictionary"), (281, "1")]);
        w.put_all(&[(0, "ENDSEC"), (0, "EOF")]);
        w.text
    }

    fn tables(&self, w: &mut Writer, layers: &[(String, u8)]) {
        w.put_all(&[(0, "SECTION"), (2, "TABLES")]);
        w.table("VPORT", "8", 0, |_| {});
        w.table("LTYPE", "5", 3, |w| {
            for (handle, name) in [("14", "ByBlock"), ("15", "ByLayer"), ("16", "Continuous")] {
                let pairs = [(2, name), (70, "0"), (3, ""), (72, "65"), (73, "0"), (40, "0")];
                w.record("LTYPE", handle, "5", "AcDbLinetypeTableRecord", &pairs);
            }
        });
        w.table("LAYER", "2", layers.len(), |w| {
            for (index, (name, colour)) in layers.iter().enumerate() {
                // Handles start at 40; six discs need 29 of them.
                let handle = format!("{:X}", 0x40 + index);
                let pairs = [(2, name.as_str()), (70, "0"), (62, &colour.to_string()), (6, "Continuous")];
                w.record("LAYER", &handle, "2", "AcDbLayerTableRecord", &pairs);
            }
        });
        w.table("STYLE", "3", 1, |w| {
            let pairs = [
                (2, "Standard"),
                (70, "0"),
                (40, "0"),
                (41, "1"),
                (50, "0"),
                (71, "0"),
                (42, "2.5"),
                (3, "txt"),
                (4, ""),
            ];
            w.record("STYLE", "11", "3", "AcDbTextStyleTableRecord", &pairs);
        });
        w.table("VIEW", "6", 0, |_| {});
        w.table("UCS", "7", 0, |_| {});
        w.table("APPID", "9", 1, |w| {
            w.record("APPID", "12", "9", "AcDbRegAppTableRecord", &[(2, "ACAD"), (70, "0")]);
        });
        w.put_all(&[
            (0, "TABLE"),
            (2, "DIMSTYLE"),
            (5, "A"),
            (330, "0"),
            (100, "AcDbSymbolTable"),
            (70, "0"),
        ]);
        w.put_all(&[(100, "AcDbDimStyleTable"), (71, "0"), (0, "ENDTAB")]);
        w.table("BLOCK_RECORD", "1", 2, |w| {
            for (handle, name) in [("1F", "*Model_Space"), ("1B", "*Paper_Space")] {
                w.record("BLOCK_RECORD", handle, "1", "AcDbBlockTableRecord", &[(2, name)]);
            }
        });
        w.put(0, "ENDSEC");
    }

    /// Whether the drawing contains marks, ring and text in addition to its contours.
    fn is_explained(&self) -> bool {
        self.options.disc.is_none()
    }

    fn entities(&self, w: &mut Writer, contour: Contour) {
        if contour.polyline() {
            w.polyline("FLANK_POLYLINE", &self.polyline());
        }
        if contour.spline() {
            w.spline("FLANK_SPLINE", &self.closed_spline());
        }
        for disc in self.discs() {
            let openings = self.openings(disc);
            let name = |kind: &str| format!("DISC_{}_{kind}", disc + 1);
            openings.bores.iter().for_each(|bore| w.circle(&name("BORES"), bore.centre, bore.radius));
            openings.holes.iter().for_each(|hole| w.circle(&name("HOLES"), hole.centre, hole.radius));
            openings.windows.iter().for_each(|window| w.outline(&name("WINDOWS"), window));
        }
        if self.is_explained() {
            self.explain(w);
        }
    }

    /// Marks, ring of pins and text.
    fn explain(&self, w: &mut Writer) {
        let (ring, _) = self.ring_radii();
        for disc in self.discs() {
            let Some(first) = self.openings(disc).bores.first().copied() else { continue };
            let layer = format!("DISC_{}_MARK", disc + 1);
            // For a bore in the centre, along the x axis.
            let towards = first.centre.try_normalize(1e-9).unwrap_or(Vec2::new(1.0, 0.0));
            let from = first.centre + first.radius * towards;
            w.line(&layer, from, from + 0.02 * ring * towards);
            w.text(&layer, from + 0.025 * ring * towards, 0.03 * ring, &(disc + 1).to_string());
        }
        match self.contour() {
            Ok(ring) => {
                w.outline("RING", &ring.opening);
                w.circle("RING", Vec2::zeros(), ring.outer_radius);
            }
            Err(_) => {
                self.pins().into_iter().for_each(|(centre, radius)| w.circle("PIN_RING", centre, radius));
            }
        }
        for (row, stamp) in self.stamps().iter().enumerate() {
            let place = Vec2::new(-ring, -1.2 * ring - 0.05 * ring * row as f64);
            w.text("STAMP", place, 0.03 * ring, stamp);
        }
    }

    /// The whole flank as one closed spline from a root around to the same root.
    pub(super) fn closed_spline(&self) -> CubicSpline {
        let mut parts = self.flanks.iter().map(|flank| flank.spline.clone());
        let first = parts.next().unwrap_or_else(|| CubicSpline { control: Vec::new(), knots: Vec::new() });
        let lobe = parts.fold(first, |lobe, next| lobe.joined(&next));
        (1..self.outline.lobe_count())
            .fold(lobe.clone(), |all, k| all.joined(&lobe.turned(unit(self.outline.lobe_pitch() * k as f64))))
    }
}
