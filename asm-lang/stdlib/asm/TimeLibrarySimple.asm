// Timers that count seconds: TimeLibrary without units.
module TimeLibrarySimple

import StandardLibrary

export *

signature:
	abstract domain Timer

	// when the timer was last started, in seconds
	controlled start: Timer -> Integer
	// how long it runs, in seconds
	controlled duration: Timer -> Integer

	// the time of this state, in whole seconds
	monitored mCurrTimeSecs: Integer

	// the time of this state
	derived currentTime: Timer -> Integer
	// whether the timer was started at least its duration ago
	derived expired: Timer -> Boolean

definitions:
	function currentTime($t in Timer) = mCurrTimeSecs

	function expired($t in Timer) =
		currentTime($t) >= start($t) + duration($t)

	// starts the timer, again if it runs
	macro rule r_reset_timer($t in Timer) =
		start($t) := currentTime($t)

	// sets how long the timer runs, in seconds
	macro rule r_set_duration($t in Timer, $duration in Integer) =
		duration($t) := $duration
