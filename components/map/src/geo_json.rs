//! GeoJSON (RFC 7946): floor plans and GIS features, drawn according to their properties.
//!
//! Coordinates are WGS 84 degrees, unless the collection has the foreign member `"map": {"units": "metres"}`; the same
//! member may contain `resolution_m`, `margin_m` and `ground`.

use asmotion_geometry::{Occupancy, Point, heading};
use geojson::{Feature, GeoJson as Document, GeometryValue, JsonObject, JsonValue, Position};

use crate::drawing::{Drawing, DrawingFrame};
use crate::error::{MapError, MapFault, Where};
use crate::format::{MapFormat, MapSettings, MapSource};
use crate::map::{LonLat, Map, NamedPoint};
use crate::projection::{Projection, centre, checked};
use crate::rules::{FeatureRule, Tags};

/// The reader of GeoJSON files.
pub struct GeoJson;

/// Default side length of a cell in m, for indoor robots.
const RESOLUTION: f64 = 0.05;

impl MapFormat for GeoJson {
    fn endings(&self) -> &'static [&'static str] {
        &[".geojson"]
    }

    fn load(&self, source: &MapSource<'_>, settings: &MapSettings) -> Result<Map, MapError> {
        let (features, about) = parse(source)?;
        let about = GeoJsonMapMember::read(about.as_ref()).map_err(|fault| source.error(fault))?;
        let place = |index: usize| move |fault| source.error_at(Where::Feature(index), fault);
        let origin = about.origin(&features, &place)?;
        let mut plan = GeoJsonReader {
            projection: origin
                .map(Projection::around)
                .transpose()
                .map_err(|fault| source.error(fault))?,
            settings,
            drawing: Drawing::default(),
            points: Vec::new(),
            ignored: 0,
        };
        for (index, feature) in features.iter().enumerate() {
            plan.add(feature).map_err(place(index))?;
        }
        plan.finish(&about, origin)
            .map_err(|fault| source.error(fault))
    }
}

fn parse(source: &MapSource<'_>) -> Result<(Vec<Feature>, Option<JsonObject>), MapError> {
    let document = source
        .text()?
        .parse()
        .map_err(|error| syntax(source, error))?;
    Ok(match document {
        Document::FeatureCollection(collection) => {
            (collection.features, collection.foreign_members)
        }
        Document::Feature(feature) => (vec![feature], None),
        Document::Geometry(geometry) => {
            let feature = Feature {
                geometry: Some(geometry),
                ..Feature::default()
            };
            (vec![feature], None)
        }
    })
}

fn syntax(source: &MapSource<'_>, error: geojson::Error) -> MapError {
    let at = if let geojson::Error::MalformedGeoJson(error) = &error
        && error.line() > 0
    {
        Where::Line {
            line: error.line() as u64,
            column: error.column() as u64,
        }
    } else {
        Where::File
    };
    let what = error.to_string();
    source.error_at(at, MapFault::Syntax { what })
}

/// The contents of the foreign member `map`.
struct GeoJsonMapMember {
    metres: bool,
    resolution: Option<f64>,
    margin: f64,
    ground: Option<Occupancy>,
}

impl GeoJsonMapMember {
    fn read(members: Option<&JsonObject>) -> Result<Self, MapFault> {
        if let Some(name) = members
            .and_then(|members| members.get("crs"))
            .and_then(foreign_crs)
        {
            return Err(MapFault::ReferenceSystem { name });
        }
        let map = members.and_then(|members| members.get("map"));
        let get = |key: &str| map.and_then(|map| map.get(key));
        let metres = match get("units") {
            None => false,
            Some(units) if units == "metres" => true,
            Some(units) if units == "degrees" => false,
            Some(units) => return Err(wrong("map.units", units, "\"metres\" or \"degrees\"")),
        };
        let ground = match get("ground").map(|ground| (ground, ground.as_str())) {
            None => None,
            Some((_, Some("free"))) => Some(Occupancy::Free),
            Some((_, Some("occupied"))) => Some(Occupancy::Occupied),
            Some((_, Some("unknown"))) => Some(Occupancy::Unknown),
            Some((ground, _)) => {
                return Err(wrong(
                    "map.ground",
                    ground,
                    "\"free\", \"occupied\" or \"unknown\"",
                ));
            }
        };
        Ok(Self {
            metres,
            resolution: length(get("resolution_m"), "map.resolution_m")?,
            margin: length(get("margin_m"), "map.margin_m")?.unwrap_or(0.0),
            ground,
        })
    }

    /// Position of the map's origin on Earth, the centre of the features; `None` if they are in metres.
    fn origin<E>(
        &self,
        features: &[Feature],
        place: &impl Fn(usize) -> E,
    ) -> Result<Option<LonLat>, MapError>
    where
        E: FnOnce(MapFault) -> MapError,
    {
        if self.metres {
            return Ok(None);
        }
        let mut places = Vec::new();
        for (index, feature) in features.iter().enumerate() {
            let Some(geometry) = &feature.geometry else {
                continue;
            };
            positions(&geometry.value, &mut |position| {
                places.push(degrees(position)?);
                Ok(())
            })
            .map_err(place(index))?;
        }
        Ok(centre(places.into_iter()))
    }
}

/// The name of a reference system other than WGS 84, which GeoJSON 2008 allowed.
fn foreign_crs(crs: &JsonValue) -> Option<String> {
    let name = crs.get("properties")?.get("name")?.as_str()?;
    let same = ["CRS84", "EPSG::4326", "EPSG:4326"]
        .iter()
        .any(|known| name.ends_with(known));
    (!same).then(|| name.to_owned())
}

fn length(value: Option<&JsonValue>, key: &str) -> Result<Option<f64>, MapFault> {
    match value.map(|value| (value, value.as_f64())) {
        None => Ok(None),
        Some((_, Some(metres))) if metres >= 0.0 => Ok(Some(metres)),
        Some((value, _)) => Err(wrong(key, value, "a length in metres")),
    }
}

fn wrong(key: &str, found: &JsonValue, expected: &'static str) -> MapFault {
    MapFault::Value {
        key: key.to_owned(),
        found: found.to_string(),
        expected,
    }
}

/// Visits every position of a geometry.
fn positions<'a>(
    geometry: &'a GeometryValue,
    visit: &mut impl FnMut(&'a Position) -> Result<(), MapFault>,
) -> Result<(), MapFault> {
    match geometry {
        GeometryValue::Point { coordinates } => visit(coordinates),
        GeometryValue::MultiPoint { coordinates } | GeometryValue::LineString { coordinates } => {
            coordinates.iter().try_for_each(visit)
        }
        GeometryValue::MultiLineString { coordinates } | GeometryValue::Polygon { coordinates } => {
            coordinates.iter().flatten().try_for_each(visit)
        }
        GeometryValue::MultiPolygon { coordinates } => {
            coordinates.iter().flatten().flatten().try_for_each(visit)
        }
        GeometryValue::GeometryCollection { geometries } => geometries
            .iter()
            .try_for_each(|geometry| positions(&geometry.value, visit)),
    }
}

fn degrees(position: &Position) -> Result<LonLat, MapFault> {
    let (x, y) = numbers(position)?;
    checked(x, y)
}

fn numbers(position: &Position) -> Result<(f64, f64), MapFault> {
    match position.as_slice() {
        [x, y, ..] if x.is_finite() && y.is_finite() => Ok((*x, *y)),
        other => Err(MapFault::Value {
            key: "coordinates".to_owned(),
            found: format!("{other:?}"),
            expected: "two finite numbers",
        }),
    }
}

/// The map under construction.
struct GeoJsonReader<'a> {
    projection: Option<Projection>,
    settings: &'a MapSettings,
    drawing: Drawing,
    points: Vec<NamedPoint>,
    /// Number of features with an extent that match no rule.
    ignored: usize,
}

impl GeoJsonReader<'_> {
    fn add(&mut self, feature: &Feature) -> Result<(), MapFault> {
        let Some(geometry) = &feature.geometry else {
            return Ok(());
        };
        let tags = tags(feature.properties.as_ref());
        let settings = self.settings;
        match settings.rules.of(&tags) {
            Some(rule) => self.draw(&geometry.value, rule, &tags)?,
            None if matches!(geometry.value, GeometryValue::Point { .. }) => {}
            None => self.ignored += 1,
        }
        self.name(&geometry.value, &tags)
    }

    fn draw(
        &mut self,
        geometry: &GeometryValue,
        rule: &FeatureRule,
        tags: &Tags,
    ) -> Result<(), MapFault> {
        match geometry {
            GeometryValue::Point { coordinates } => {
                let at = self.point(coordinates)?;
                self.drawing.spot(at, rule.spot_of(tags), rule);
            }
            GeometryValue::MultiPoint { coordinates } => {
                for at in self.points(coordinates)? {
                    self.drawing.spot(at, rule.spot_of(tags), rule);
                }
            }
            GeometryValue::LineString { coordinates } => self.line(coordinates, rule, tags)?,
            GeometryValue::MultiLineString { coordinates } => {
                for line in coordinates {
                    self.line(line, rule, tags)?;
                }
            }
            GeometryValue::Polygon { coordinates } => self.area(coordinates, rule)?,
            GeometryValue::MultiPolygon { coordinates } => {
                for polygon in coordinates {
                    self.area(polygon, rule)?;
                }
            }
            GeometryValue::GeometryCollection { geometries } => {
                for geometry in geometries {
                    self.draw(&geometry.value, rule, tags)?;
                }
            }
        }
        Ok(())
    }

    fn line(&mut self, line: &[Position], rule: &FeatureRule, tags: &Tags) -> Result<(), MapFault> {
        let points = self.points(line)?;
        self.drawing.line(points, rule.width_of(tags), rule);
        Ok(())
    }

    fn area(&mut self, rings: &[Vec<Position>], rule: &FeatureRule) -> Result<(), MapFault> {
        let rings = rings.iter().map(|ring| self.points(ring));
        let rings = rings.collect::<Result<_, _>>()?;
        self.drawing.area(rings, rule);
        Ok(())
    }

    /// Adds a point with a name as a named place; `yaw_deg` is its heading.
    fn name(&mut self, geometry: &GeometryValue, tags: &Tags) -> Result<(), MapFault> {
        if let (GeometryValue::Point { coordinates }, Some(name)) = (geometry, tags.get("name")) {
            let yaw: f64 = tags
                .get("yaw_deg")
                .and_then(|yaw| yaw.parse().ok())
                .unwrap_or(0.0);
            self.points.push(NamedPoint {
                name: name.clone(),
                pose: heading(self.point(coordinates)?, yaw.to_radians()),
            });
        }
        Ok(())
    }

    fn points(&self, positions: &[Position]) -> Result<Vec<Point>, MapFault> {
        positions
            .iter()
            .map(|position| self.point(position))
            .collect()
    }

    fn point(&self, position: &Position) -> Result<Point, MapFault> {
        match &self.projection {
            Some(projection) => projection.project(degrees(position)?),
            None => numbers(position).map(|(x, y)| Point::new(x, y)),
        }
    }

    fn finish(self, about: &GeoJsonMapMember, origin: Option<LonLat>) -> Result<Map, MapFault> {
        let (low, high) = self.drawing.bounds().ok_or(MapFault::Nothing)?;
        let settings = self.settings;
        let frame = DrawingFrame {
            low,
            high,
            resolution: settings
                .resolution
                .or(about.resolution)
                .unwrap_or(RESOLUTION),
            ground: settings.ground.or(about.ground).unwrap_or(Occupancy::Free),
        };
        let grid = self.drawing.grid(&frame.widened(about.margin), settings)?;
        let notes = match self.ignored {
            0 => Vec::new(),
            count => vec![format!("{count} features match no rule and were not drawn")],
        };
        Ok(Map {
            grid,
            points: self.points,
            origin,
            notes,
        })
    }
}

/// Converts a feature's properties to tags: texts, numbers and Booleans.
fn tags(properties: Option<&JsonObject>) -> Tags {
    let text = |value: &JsonValue| match value {
        JsonValue::String(text) => Some(text.clone()),
        JsonValue::Number(number) => Some(number.to_string()),
        JsonValue::Bool(true) => Some("yes".to_owned()),
        JsonValue::Bool(false) => Some("no".to_owned()),
        JsonValue::Null | JsonValue::Array(_) | JsonValue::Object(_) => None,
    };
    let properties = properties.into_iter().flatten();
    properties
        .filter_map(|(key, value)| Some((key.clone(), text(value)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::FilesInMemory;
    use crate::formats::load;
    use asmotion_geometry::{Cell, yaw};

    fn read(text: &str) -> Result<Map, MapError> {
        load(
            &FilesInMemory::new([("a.geojson", text)]),
            "a.geojson",
            &MapSettings::default(),
        )
    }

    fn collection(map: &str, features: &str) -> String {
        format!(r#"{{"type":"FeatureCollection","map":{map},"features":[{features}]}}"#)
    }

    const ROOM: &str = r#"
        {"type":"Feature","properties":{"indoor":"room"},"geometry":{"type":"Polygon","coordinates":[[[0,0],[4,0],[4,3],[0,3],[0,0]]]}},
        {"type":"Feature","properties":{"indoor":"wall","width_m":1},"geometry":{"type":"LineString","coordinates":[[0,0],[4,0]]}},
        {"type":"Feature","properties":{"name":"dock","yaw_deg":90},"geometry":{"type":"Point","coordinates":[1.5,2.5]}},
        {"type":"Feature","properties":{"colour":"red"},"geometry":{"type":"LineString","coordinates":[[9,9],[9,8]]}}"#;

    #[test]
    fn it_draws_a_room_in_metres() {
        let about = r#"{"units":"metres","resolution_m":0.5,"margin_m":1,"ground":"unknown"}"#;
        let map = read(&collection(about, ROOM)).unwrap();
        let at = |x: f64, y: f64| map.grid.occupancy(Point::new(x, y));
        assert_eq!(map.grid.layout().width(), 12);
        assert_eq!(at(2.2, 0.2), Occupancy::Occupied);
        assert_eq!(at(2.2, 1.2), Occupancy::Free);
        assert_eq!(at(2.2, 3.2), Occupancy::Unknown);
        assert_eq!(map.origin, None);
        assert_eq!(map.notes, ["1 features match no rule and were not drawn"]);
    }

    #[test]
    fn it_knows_named_places() {
        let map = read(&collection(r#"{"units":"metres"}"#, ROOM)).unwrap();
        let dock = map.point("dock").unwrap();
        assert_eq!(dock.pose.translation.vector.as_slice(), [1.5, 2.5]);
        assert!((yaw(&dock.pose) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!(map.point("moon").is_none());
    }

    #[test]
    fn it_projects_degrees_around_their_middle() {
        let building = r#"{"type":"Feature","properties":{"building":"yes"},"geometry":{"type":"Polygon","coordinates":[[[13.3501,52.5145],[13.3503,52.5145],[13.3503,52.5147],[13.3501,52.5147],[13.3501,52.5145]]]}}"#;
        let map = read(&collection("{}", building)).unwrap();
        let origin = map.origin.unwrap();
        assert!(
            (origin.longitude - 13.3502).abs() < 1e-9 && (origin.latitude - 52.5146).abs() < 1e-9
        );
        // 0.0002° are 13.58 m east-west and 22.26 m north-south here
        let layout = map.grid.layout();
        let size = (
            f64::from(layout.width()) * 0.05,
            f64::from(layout.height()) * 0.05,
        );
        assert!(
            (size.0 - 13.58).abs() < 0.15 && (size.1 - 22.26).abs() < 0.15,
            "{size:?}"
        );
        assert_eq!(map.grid.get(Cell::new(5, 5)), Some(100));
    }

    #[test]
    fn it_says_what_is_wrong_and_where() {
        let error = |text: &str| read(text).unwrap_err().to_string();
        let far = r#"{"type":"Feature","properties":{"indoor":"wall"},"geometry":{"type":"LineString","coordinates":[[0,0],[400,0]]}}"#;
        let metres = error(&collection("{}", far));
        assert!(
            metres.starts_with("a.geojson, features[0]: (400, 0) is not a longitude"),
            "{metres}"
        );
        assert!(metres.contains(r#""map": {"units": "metres"}"#));
        assert!(error(&collection(r#"{"units":"feet"}"#, far)).contains("`map.units` is \"feet\""));
        assert!(
            error(&collection(r#"{"units":"metres"}"#, "")).contains("no element can be drawn")
        );
        assert!(
            error("{\n \"type\":").starts_with("a.geojson:2:"),
            "{}",
            error("{\n \"type\":")
        );
        let crs = r#"{"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:25833"}},"features":[]}"#;
        assert!(error(crs).contains("EPSG:25833"));
        let large = error(&collection(
            r#"{"units":"metres","resolution_m":0.001}"#,
            &far.replace("[400,0]", "[400,300]"),
        ));
        assert!(large.contains("set `resolution_m` to "), "{large}");
    }
}
