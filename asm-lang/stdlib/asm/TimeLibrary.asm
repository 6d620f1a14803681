// Timers over a monitored clock. A timer is set with r_set_duration (and r_set_timer_unit),
// started with r_reset_timer, and asked with expired.
//
//     static patience: Timer
//     ...
//     r_reset_timer[patience]              // from now on
//     if expired(patience) then ...        // its duration has passed
module TimeLibrary

import StandardLibrary

export *

signature:
	abstract domain Timer
	enum domain TimerUnit = {NANOSEC | MILLISEC | SEC | MIN | HOUR}

	// when the timer was last started, in its own unit
	controlled start: Timer -> Integer
	// how long it runs, in its own unit
	controlled duration: Timer -> Integer
	// what it counts in; a timer without a unit counts seconds
	controlled timerUnit: Timer -> TimerUnit

	// the time of this state. All five show one instant, each cut to a whole number of its unit
	monitored mCurrTimeNanosecs: Integer
	monitored mCurrTimeMillisecs: Integer
	monitored mCurrTimeSecs: Integer
	monitored mCurrTimeMins: Integer
	monitored mCurrTimeHours: Integer

	// the time of this state, in the unit of the timer
	derived currentTime: Timer -> Integer
	// whether the timer was started at least its duration ago
	derived expired: Timer -> Boolean

definitions:
	function currentTime($t in Timer) =
		switch timerUnit($t)
			case NANOSEC: mCurrTimeNanosecs
			case MILLISEC: mCurrTimeMillisecs
			case MIN: mCurrTimeMins
			case HOUR: mCurrTimeHours
			otherwise mCurrTimeSecs
		endswitch

	function expired($t in Timer) =
		currentTime($t) >= start($t) + duration($t)

	// starts the timer, again if it runs
	macro rule r_reset_timer($t in Timer) =
		start($t) := currentTime($t)

	// sets how long the timer runs, in its unit
	macro rule r_set_duration($t in Timer, $duration in Integer) =
		duration($t) := $duration

	// sets what the timer counts in; start and duration keep their numbers
	macro rule r_set_timer_unit($t in Timer, $unit in TimerUnit) =
		timerUnit($t) := $unit
