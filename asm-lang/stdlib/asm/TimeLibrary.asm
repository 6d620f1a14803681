// Timers over a monitored clock. A timer is set with r_set_duration (and r_set_timer_unit),
// started with r_reset_timer, and queried with expired.
//
//     static patience: Timer
//     ...
//     r_reset_timer[patience]              // starts now
//     if expired(patience) then ...        // its duration has passed
module TimeLibrary

import StandardLibrary

export *

signature:
	abstract domain Timer
	enum domain TimerUnit = {NANOSEC | MILLISEC | SEC | MIN | HOUR}

	// time of the last start, in the timer's own unit
	controlled start: Timer -> Integer
	// duration, in the timer's own unit
	controlled duration: Timer -> Integer
	// unit of the timer; seconds if it has none
	controlled timerUnit: Timer -> TimerUnit

	// the time of the current state; all five return the same instant, rounded down to their unit
	monitored mCurrTimeNanosecs: Integer
	monitored mCurrTimeMillisecs: Integer
	monitored mCurrTimeSecs: Integer
	monitored mCurrTimeMins: Integer
	monitored mCurrTimeHours: Integer

	// the time of the current state, in the unit of the timer
	derived currentTime: Timer -> Integer
	// true if the timer was started at least its duration ago
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

	// starts or restarts the timer
	macro rule r_reset_timer($t in Timer) =
		start($t) := currentTime($t)

	// sets the duration of the timer, in its unit
	macro rule r_set_duration($t in Timer, $duration in Integer) =
		duration($t) := $duration

	// sets the unit of the timer; the values of start and duration are not converted
	macro rule r_set_timer_unit($t in Timer, $unit in TimerUnit) =
		timerUnit($t) := $unit
