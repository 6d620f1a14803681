// The library of timers without a clock: a timer may have expired in any step.
module TimeLibrary

import StandardLibrary

export *

signature:
	abstract domain Timer
	enum domain TimerUnit = {NANOSEC | MILLISEC | SEC | MIN | HOUR}

	controlled start: Timer -> Integer
	controlled duration: Timer -> Integer
	controlled timerUnit: Timer -> TimerUnit

	monitored mCurrTimeNanosecs: Integer
	monitored mCurrTimeMillisecs: Integer
	monitored mCurrTimeSecs: Integer
	monitored mCurrTimeMins: Integer
	monitored mCurrTimeHours: Integer

	derived currentTime: Timer -> Integer
	monitored expired: Timer -> Boolean

definitions:
	function currentTime($t in Timer) =
		switch timerUnit($t)
			case NANOSEC: mCurrTimeNanosecs
			case MILLISEC: mCurrTimeMillisecs
			case MIN: mCurrTimeMins
			case HOUR: mCurrTimeHours
			otherwise mCurrTimeSecs
		endswitch

	macro rule r_reset_timer($t in Timer) = skip

	macro rule r_set_duration($t in Timer, $duration in Integer) = skip

	macro rule r_set_timer_unit($t in Timer, $unit in TimerUnit) = skip
