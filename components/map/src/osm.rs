//! OpenStreetMap extracts (<https://wiki.openstreetmap.org/wiki/Elements>): the rules determine what is drawn; by
//! default buildings, barriers and water are occupied, and ways are free. Both file formats share this code.

mod extract;
mod pbf;
mod rings;
mod wire;
#[cfg(feature = "maps")]
mod xml;

use asmotion_geometry::{Occupancy, Point};

use crate::drawing::{Drawing, DrawingFrame};
use crate::error::{MapError, MapFault};
use crate::format::{MapFormat, MapSettings, MapSource};
use crate::map::{LonLat, Map, NamedPoint};
use crate::projection::{Projection, bounds};
use crate::rules::{FeatureRule, Tags};
use extract::Extract;

/// The reader of OSM XML files.
#[cfg(feature = "maps")]
pub struct OsmXml;

/// The reader of OSM PBF files.
pub struct OsmPbf;

/// Default side length of a cell in m, for streets and yards.
const RESOLUTION: f64 = 0.5;

#[cfg(feature = "maps")]
impl MapFormat for OsmXml {
    fn endings(&self) -> &'static [&'static str] {
        &[".osm", ".osm.xml"]
    }

    fn load(&self, source: &MapSource<'_>, settings: &MapSettings) -> Result<Map, MapError> {
        let extract = xml::read(source, &settings.rules)?;
        draw(&extract, settings).map_err(|fault| source.error(fault))
    }
}

impl MapFormat for OsmPbf {
    fn endings(&self) -> &'static [&'static str] {
        &[".osm.pbf", ".pbf"]
    }

    fn load(&self, source: &MapSource<'_>, settings: &MapSettings) -> Result<Map, MapError> {
        let extract = pbf::read(source, &settings.rules)?;
        draw(&extract, settings).map_err(|fault| source.error(fault))
    }
}

/// Draws the map of an extract, with the extract's own bounds or else those of the drawing.
fn draw(extract: &Extract, settings: &MapSettings) -> Result<Map, MapFault> {
    let corners = extract
        .bounds
        .or_else(|| bounds(extract.nodes.values().copied()));
    let (low, high) = corners.ok_or(MapFault::Nothing)?;
    let origin = LonLat {
        longitude: (low.longitude + high.longitude) / 2.0,
        latitude: (low.latitude + high.latitude) / 2.0,
    };
    let mut city = City {
        projection: Projection::around(origin)?,
        extract,
        settings,
        drawing: Drawing::default(),
        points: Vec::new(),
        broken: 0,
    };
    city.add_ways()?;
    city.add_relations()?;
    city.add_nodes()?;
    let (low, high) = city.frame(low, high)?;
    let frame = DrawingFrame {
        low,
        high,
        resolution: settings.resolution.unwrap_or(RESOLUTION),
        ground: settings.ground.unwrap_or(Occupancy::Free),
    };
    Ok(Map {
        grid: city.drawing.grid(&frame, settings)?,
        points: city.points,
        origin: Some(origin),
        notes: match city.broken {
            0 => Vec::new(),
            count => vec![format!(
                "{count} elements reach beyond the extract and were drawn in part"
            )],
        },
    })
}

/// The map under construction.
struct City<'a> {
    projection: Projection,
    extract: &'a Extract,
    settings: &'a MapSettings,
    drawing: Drawing,
    points: Vec<NamedPoint>,
    /// Number of elements with members that the extract does not contain.
    broken: usize,
}

impl City<'_> {
    fn add_ways(&mut self) -> Result<(), MapFault> {
        for way in &self.extract.ways {
            let Some(rule) = self.settings.rules.of(&way.tags) else {
                continue;
            };
            let closed = way.nodes.len() > 3 && way.nodes.first() == way.nodes.last();
            if closed && is_area(rule, &way.tags) {
                let ring = self.known(&way.nodes)?.concat();
                self.drawing.area(vec![ring], rule);
            } else {
                for line in self.known(&way.nodes)? {
                    self.drawing.line(line, rule.width_of(&way.tags), rule);
                }
            }
        }
        Ok(())
    }

    /// Adds areas with holes or several parts (<https://wiki.openstreetmap.org/wiki/Relation:multipolygon>).
    fn add_relations(&mut self) -> Result<(), MapFault> {
        let extract = self.extract;
        let areas = extract.relations.iter().filter(|relation| {
            let kind = relation.tags.get("type").map(String::as_str);
            kind == Some("multipolygon")
        });
        for relation in areas {
            let Some(rule) = self.settings.rules.of(&relation.tags) else {
                continue;
            };
            let members = relation.ways.iter().filter_map(|id| extract.way(*id));
            let parts: Vec<&[i64]> = members.map(|way| &way.nodes[..]).collect();
            let rings = rings::join(&parts);
            if parts.len() < relation.ways.len() || !rings.open.is_empty() {
                self.broken += 1;
            }
            let closed = rings
                .closed
                .iter()
                .map(|ring| Ok(self.known(ring)?.concat()));
            let closed = closed.collect::<Result<_, MapFault>>()?;
            self.drawing.area(closed, rule);
            self.add_banks(&rings.open, rule)?;
        }
        Ok(())
    }

    /// Draws the known border of an occupied area that is not closed.
    fn add_banks(&mut self, banks: &[Vec<i64>], rule: &FeatureRule) -> Result<(), MapFault> {
        if rule.occupancy != Some(Occupancy::Occupied) {
            return Ok(());
        }
        for bank in banks {
            for line in self.known(bank)? {
                self.drawing.line(line, 0.0, rule);
            }
        }
        Ok(())
    }

    fn add_nodes(&mut self) -> Result<(), MapFault> {
        for (id, tags) in &self.extract.spots {
            let Some(place) = self.extract.nodes.get(id) else {
                continue;
            };
            let at = self.projection.project(*place)?;
            if let Some(rule) = self.settings.rules.of(tags) {
                self.drawing.spot(at, rule.spot_of(tags), rule);
            }
            if let Some(name) = tags.get("name") {
                self.points.push(NamedPoint {
                    name: name.clone(),
                    pose: asmotion_geometry::heading(at, 0.0),
                });
            }
        }
        Ok(())
    }

    /// The points of a way, split where the extract lacks nodes.
    fn known(&mut self, nodes: &[i64]) -> Result<Vec<Vec<Point>>, MapFault> {
        let mut pieces = Vec::new();
        for known in nodes.split(|id| !self.extract.nodes.contains_key(id)) {
            let places = known.iter().filter_map(|id| self.extract.nodes.get(id));
            let points = places.map(|place| self.projection.project(*place));
            let points: Vec<Point> = points.collect::<Result<_, _>>()?;
            if !points.is_empty() {
                pieces.push(points);
            }
        }
        if pieces.len() != 1 {
            self.broken += 1;
        }
        Ok(pieces)
    }

    /// The bounds of the map: the projected corners of the extract, or the bounds of the drawing.
    fn frame(&self, low: LonLat, high: LonLat) -> Result<(Point, Point), MapFault> {
        if self.extract.bounds.is_none() {
            return self.drawing.bounds().ok_or(MapFault::Nothing);
        }
        let corner = |longitude, latitude| {
            let place = LonLat {
                longitude,
                latitude,
            };
            self.projection.project(place)
        };
        let corners = [
            corner(low.longitude, low.latitude)?,
            corner(high.longitude, low.latitude)?,
            corner(high.longitude, high.latitude)?,
            corner(low.longitude, high.latitude)?,
        ];
        Ok(corners
            .iter()
            .fold((corners[0], corners[0]), |(low, high), point| {
                (low.inf(point), high.sup(point))
            }))
    }
}

/// Returns whether a closed way stands for the area within.
fn is_area(rule: &FeatureRule, tags: &Tags) -> bool {
    match tags.get("area").map(String::as_str) {
        Some("yes") => true,
        Some("no") => false,
        _ => rule.area,
    }
}
