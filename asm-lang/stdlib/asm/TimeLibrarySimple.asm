// Timers that count seconds: TimeLibrary without units.
module TimeLibrarySimple

import StandardLibrary

export *

signature:
	abstract domain Timer

	// time of the last start, in seconds
	controlled start: Timer -> Integer
	// duration, in seconds
	controlled duration: Timer -> Integer

	// the time of the current state, in whole seconds
	monitored mCurrTimeSecs: Integer

	// the time of the current state
	derived currentTime: Timer -> Integer
	// true if the timer was started at least its duration ago
	derived expired: Timer -> Boolean

definitions:
	function currentTime($t in Timer) = mCurrTimeSecs

	function expired($t in Timer) =
		currentTime($t) >= start($t) + duration($t)

	// starts or restarts the timer
	macro rule r_reset_timer($t in Timer) =
		start($t) := currentTime($t)

	// sets the duration of the timer, in seconds
	macro rule r_set_duration($t in Timer, $duration in Integer) =
		duration($t) := $duration
