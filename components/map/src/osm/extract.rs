//! The elements of an extract that are relevant to a map.

use std::collections::HashMap;

use crate::error::MapFault;
use crate::map::LonLat;
use crate::projection::checked;
use crate::rules::{Rules, Tags};

/// Keys of tags that are always kept, besides those of the rules.
const ALWAYS: &[&str] = &["type", "area", "width", "name"];

/// Limit on the number of nodes, ways and relations; uses a few hundred megabytes.
const MOST: usize = 4_000_000;

/// Nodes, ways and relations, without tags that no rule uses.
#[derive(Default)]
pub struct Extract {
    /// South-west and north-east corner, if the file specifies them.
    pub bounds: Option<(LonLat, LonLat)>,
    /// Positions by id. A hash map, which is never iterated over, so its order has no effect.
    pub nodes: HashMap<i64, LonLat>,
    /// Nodes with tags, in the order of the file.
    pub spots: Vec<(i64, Tags)>,
    /// Ways, in the order of the file.
    pub ways: Vec<OsmWay>,
    /// Relations, in the order of the file.
    pub relations: Vec<OsmRelation>,
    by_id: HashMap<i64, usize>,
    elements: usize,
}

/// A sequence of nodes.
pub struct OsmWay {
    pub id: i64,
    pub nodes: Vec<i64>,
    pub tags: Tags,
}

/// A group of elements, of which only the ways are kept.
pub struct OsmRelation {
    pub ways: Vec<i64>,
    pub tags: Tags,
}

impl Extract {
    pub fn add_node(&mut self, id: i64, place: (f64, f64), tags: Tags) -> Result<(), MapFault> {
        self.count(1)?;
        self.nodes.insert(id, checked(place.0, place.1)?);
        if !tags.is_empty() {
            self.spots.push((id, tags));
        }
        Ok(())
    }

    pub fn add_way(&mut self, way: OsmWay) -> Result<(), MapFault> {
        self.count(1 + way.nodes.len() / 8)?;
        self.by_id.insert(way.id, self.ways.len());
        self.ways.push(way);
        Ok(())
    }

    pub fn add_relation(&mut self, relation: OsmRelation) -> Result<(), MapFault> {
        self.count(1 + relation.ways.len() / 8)?;
        self.relations.push(relation);
        Ok(())
    }

    pub fn way(&self, id: i64) -> Option<&OsmWay> {
        self.ways.get(*self.by_id.get(&id)?)
    }

    fn count(&mut self, more: usize) -> Result<(), MapFault> {
        self.elements += more;
        if self.elements > MOST {
            return Err(MapFault::TooManyElements { limit: MOST });
        }
        Ok(())
    }
}

/// Returns whether a tag with this key is kept.
pub fn matters(rules: &Rules, key: &str) -> bool {
    ALWAYS.contains(&key) || rules.uses_key(key)
}
