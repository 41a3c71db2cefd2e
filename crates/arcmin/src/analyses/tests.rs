use super::*;

/// One key means one thing: whatever analysis or table gives it.
#[test]
fn a_key_has_one_meaning_everywhere() {
    let mut meanings: std::collections::BTreeMap<&str, (&str, String)> = Default::default();
    for analysis in ALL {
        let declared = (analysis.results)();
        let columns = declared.tables.iter().flat_map(|table| table.columns.iter());
        for quantity in columns.chain(declared.summary.iter()) {
            let place = declared.analysis.to_owned();
            let (what, first) = meanings.entry(quantity.key).or_insert((quantity.what, place.clone()));
            assert_eq!(*what, quantity.what, "{} of {place} and {first}", quantity.key);
        }
    }
}

/// No table and no summary names a quantity twice, and every quantity says what it is in a sentence.
#[test]
fn results_are_declared_once_and_documented() {
    for analysis in ALL {
        let declared = (analysis.results)();
        let mut lists: Vec<_> = declared.tables.iter().map(|table| table.columns.clone()).collect();
        lists.push(declared.summary.clone());
        for list in lists {
            let mut keys: Vec<&str> = list.iter().map(|quantity| quantity.key).collect();
            keys.sort_unstable();
            assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{}: {keys:?}", analysis.name);
            assert!(list.iter().all(|quantity| quantity.what.ends_with('.')), "{}", analysis.name);
        }
    }
}

/// Options are documented, and their defaults can be read.
#[test]
fn options_have_defaults_and_documentation() {
    for analysis in ALL {
        for key in (analysis.options)().keys {
            assert!(key.doc.trim().ends_with('.'), "{}: {}", analysis.name, key.name);
        }
    }
}
