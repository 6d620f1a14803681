//! Projects longitude and latitude to metres by a transverse Mercator projection around the map's own centre (proj4rs).
//!
//! Within 10 km of the centre it agrees with the local tangent plane (ENU, REP-105's `map`) to a few centimetres.

use asmotion_geometry::Point;
use proj4rs::Proj;

use crate::error::MapFault;
use crate::map::LonLat;

/// Projects positions on Earth to the map frame.
pub struct Projection {
    degrees: Proj,
    metres: Proj,
}

impl Projection {
    /// The projection to metres east and north of `centre`.
    pub fn around(centre: LonLat) -> Result<Self, MapFault> {
        let LonLat {
            longitude,
            latitude,
        } = checked(centre.longitude, centre.latitude)?;
        let metres = format!(
            "+proj=tmerc +lat_0={latitude:.12} +lon_0={longitude:.12} +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m"
        );
        let made = |text: &str| {
            Proj::from_proj_string(text).map_err(|error| MapFault::Syntax {
                what: format!("no projection around ({longitude}, {latitude}): {error}"),
            })
        };
        Ok(Self {
            degrees: made("+proj=longlat +ellps=WGS84")?,
            metres: made(&metres)?,
        })
    }

    /// Projects a position on Earth to the map frame, m.
    pub fn project(&self, place: LonLat) -> Result<Point, MapFault> {
        let LonLat {
            longitude,
            latitude,
        } = checked(place.longitude, place.latitude)?;
        let far = MapFault::TooFar {
            longitude,
            latitude,
        };
        let mut point = (longitude.to_radians(), latitude.to_radians(), 0.0);
        match proj4rs::transform::transform(&self.degrees, &self.metres, &mut point) {
            Ok(()) if point.0.is_finite() && point.1.is_finite() => {
                Ok(Point::new(point.0, point.1))
            }
            Ok(()) | Err(_) => Err(far),
        }
    }
}

/// Checks that two numbers are a longitude and a latitude in degrees.
pub fn checked(longitude: f64, latitude: f64) -> Result<LonLat, MapFault> {
    if !(-180.0..=180.0).contains(&longitude) || !(-90.0..=90.0).contains(&latitude) {
        return Err(MapFault::NotDegrees {
            x: longitude,
            y: latitude,
        });
    }
    Ok(LonLat {
        longitude,
        latitude,
    })
}

/// The centre of the bounding box of positions; `None` without any.
pub fn centre(places: impl Iterator<Item = LonLat>) -> Option<LonLat> {
    let (low, high) = bounds(places)?;
    Some(LonLat {
        longitude: (low.longitude + high.longitude) / 2.0,
        latitude: (low.latitude + high.latitude) / 2.0,
    })
}

/// The south-west and north-east corner of the bounding box of positions; `None` without any.
pub fn bounds(mut places: impl Iterator<Item = LonLat>) -> Option<(LonLat, LonLat)> {
    let first = places.next()?;
    Some(places.fold((first, first), |(low, high), place| {
        let pick = |choose: fn(f64, f64) -> f64, one: LonLat| LonLat {
            longitude: choose(one.longitude, place.longitude),
            latitude: choose(one.latitude, place.latitude),
        };
        (pick(f64::min, low), pick(f64::max, high))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radii of curvature of WGS 84 at a latitude, east-west and north-south, m.
    fn radii(latitude: f64) -> (f64, f64) {
        let (a, e2) = (6_378_137.0, 0.006_694_379_990_141_32_f64);
        let w = (1.0 - e2 * latitude.to_radians().sin().powi(2)).sqrt();
        (
            a / w * latitude.to_radians().cos(),
            a * (1.0 - e2) / w.powi(3),
        )
    }

    #[test]
    fn it_measures_metres_east_and_north() {
        for latitude in [-33.9, 0.0, 1.28, 41.9, 52.5] {
            let centre = LonLat {
                longitude: 13.35,
                latitude,
            };
            let projection = Projection::around(centre).unwrap();
            let place = LonLat {
                longitude: 13.351,
                latitude: latitude + 0.001,
            };
            let point = projection.project(place).unwrap();
            let (east, north) = radii(latitude + 0.0005);
            assert!(
                (point.x - east * 0.001_f64.to_radians()).abs() < 0.01,
                "{point}"
            );
            assert!(
                (point.y - north * 0.001_f64.to_radians()).abs() < 0.01,
                "{point}"
            );
            assert!(projection.project(centre).unwrap().coords.norm() < 1e-6);
        }
    }

    #[test]
    fn it_refuses_what_is_not_on_earth() {
        for (longitude, latitude) in [(200.0, 0.0), (0.0, 91.0), (f64::NAN, 0.0)] {
            assert!(matches!(
                checked(longitude, latitude),
                Err(MapFault::NotDegrees { .. })
            ));
        }
    }
}
