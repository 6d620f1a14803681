//! OSM PBF (<https://wiki.openstreetmap.org/wiki/PBF_Format>), read with osmpbf.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use osmpbf::{BlobDecode, BlobReader, Element, HeaderBlock, PrimitiveBlock, RelMemberType};

use super::extract::{Extract, Relation, Way, matters};
use crate::format::Source;
use crate::projection::checked;
use crate::{Fault, LonLat, MapError, Rules, Tags};

/// The elements of the file.
pub fn read(source: &Source<'_>, rules: &Rules) -> Result<Extract, MapError> {
    let bytes = source.bytes()?;
    // osmpbf 0.3 panics on an unknown member type, and in debug builds on deltas that overflow; only damaged files
    // have them, and a damaged file must not take the robot down
    let read = catch_unwind(AssertUnwindSafe(|| blobs(&bytes, rules)));
    let damaged = |_| syntax("a block's numbers are damaged");
    read.map_err(damaged)
        .flatten()
        .map_err(|fault| source.error(fault))
}

fn blobs(bytes: &[u8], rules: &Rules) -> Result<Extract, Fault> {
    let mut extract = Extract::default();
    let mut headers = 0;
    for blob in BlobReader::new(Cursor::new(bytes)) {
        let blob = blob.map_err(syntax)?;
        match blob.decode().map_err(syntax)? {
            BlobDecode::OsmHeader(header) => {
                headers += 1;
                extract.bounds = extract.bounds.or(corners(&header)?);
            }
            BlobDecode::OsmData(block) => add_block(&mut extract, &block, rules)?,
            BlobDecode::Unknown(_) => {}
        }
    }
    if headers == 0 {
        return Err(syntax("is no OSM PBF file: it has no header block"));
    }
    Ok(extract)
}

fn syntax(what: impl ToString) -> Fault {
    Fault::Syntax {
        what: what.to_string(),
    }
}

fn corners(header: &HeaderBlock) -> Result<Option<(LonLat, LonLat)>, Fault> {
    let Some(bounds) = header.bbox() else {
        return Ok(None);
    };
    let low = checked(bounds.left, bounds.bottom)?;
    let high = checked(bounds.right, bounds.top)?;
    Ok(Some((low, high)))
}

fn add_block(extract: &mut Extract, block: &PrimitiveBlock, rules: &Rules) -> Result<(), Fault> {
    block
        .elements()
        .try_for_each(|element| add(extract, element, rules))
}

fn add(extract: &mut Extract, element: Element<'_>, rules: &Rules) -> Result<(), Fault> {
    match element {
        Element::Node(node) => {
            let place = (node.lon(), node.lat());
            extract.add_node(node.id(), place, tags(node.tags(), rules))
        }
        Element::DenseNode(node) => {
            let place = (node.lon(), node.lat());
            extract.add_node(node.id(), place, tags(node.tags(), rules))
        }
        Element::Way(way) => extract.add_way(Way {
            id: way.id(),
            nodes: way.refs().collect(),
            tags: tags(way.tags(), rules),
        }),
        Element::Relation(relation) => {
            let members = relation.members();
            let ways = members.filter(|member| member.member_type == RelMemberType::Way);
            extract.add_relation(Relation {
                ways: ways.map(|member| member.member_id).collect(),
                tags: tags(relation.tags(), rules),
            })
        }
    }
}

fn tags<'a>(pairs: impl Iterator<Item = (&'a str, &'a str)>, rules: &Rules) -> Tags {
    let wanted = pairs.filter(|(key, _)| matters(rules, key));
    wanted
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect()
}
