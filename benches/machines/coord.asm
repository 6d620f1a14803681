asm coord
import StandardLibrary

signature:
	enum domain Stdom = {
		BOOT_ST | READY_ST | ORDER_ST | PAY_ST | SHIP_ST | WAITS_ST | RECOVER_ST | FAILED_ST
	}
	enum domain Evdom = {TICK_EV | REQ_EV | ACK_EV | NACK_EV | TMO_EV | RST_EV}
	enum domain Svcdom = {AUTH_SVC | STOCK_SVC | BANK_SVC | MAIL_SVC}
	enum domain SStatdom = {UP_SSTAT | SLOW_SSTAT | DOWN_SSTAT}
	dynamic controlled st: Stdom
	dynamic controlled ev: Evdom
	dynamic controlled seed: Integer
	dynamic controlled retries: Integer
	dynamic controlled timer: Integer
	dynamic controlled ticks: Integer
	dynamic controlled idle: Integer
	dynamic controlled orders: Integer
	dynamic controlled errors: Integer
	dynamic controlled svc: Svcdom -> SStatdom
	dynamic controlled calls: Svcdom -> Integer
	dynamic controlled down: Svcdom -> Integer
	dynamic controlled hist: Stdom -> Integer

definitions:
	rule r_event =
		let ($z = (seed * 8121 + 28411) mod 134456) in
			par
				seed := $z
				switch $z mod 6
					case 0:
						ev := TICK_EV
					case 1:
						ev := REQ_EV
					case 2:
						ev := ACK_EV
					case 3:
						ev := NACK_EV
					case 4:
						ev := TMO_EV
					otherwise
						ev := RST_EV
				endswitch
			endpar
		endlet

	rule r_service($s in Svcdom) =
		switch svc($s)
			case UP_SSTAT:
				if (seed + calls($s)) mod 11 = 0 then
					svc($s) := SLOW_SSTAT
				endif
			case SLOW_SSTAT:
				if (seed + calls($s)) mod 5 = 0 then
					svc($s) := DOWN_SSTAT
				else
					if seed mod 3 = 0 then
						svc($s) := UP_SSTAT
					endif
				endif
			otherwise
				if down($s) > 3 then
					par
						svc($s) := UP_SSTAT
						down($s) := 0
					endpar
				else
					down($s) := down($s) + 1
				endif
		endswitch

	rule r_timer =
		if timer > 0 then
			ticks := ticks + 1
		else
			idle := idle + 1
		endif

	rule r_boot_tick =
		if svc(STOCK_SVC) = UP_SSTAT then
			par
				st := READY_ST
				calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
				timer := 2
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_boot_ack =
		if svc(AUTH_SVC) = UP_SSTAT then
			par
				st := READY_ST
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				timer := 2
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_boot_nack =
		if svc(AUTH_SVC) = UP_SSTAT then
			par
				st := READY_ST
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				timer := 7
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_boot_tmo =
		if svc(AUTH_SVC) = DOWN_SSTAT then
			par
				st := RECOVER_ST
				errors := errors + 1
			endpar
		else
			if ticks mod 4 = 1 then
				par
					st := READY_ST
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				orders := orders + 1
			endif
		endif

	rule r_boot_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_boot =
		switch ev
			case TICK_EV:
				r_boot_tick[]
			case ACK_EV:
				r_boot_ack[]
			case NACK_EV:
				r_boot_nack[]
			case TMO_EV:
				r_boot_tmo[]
			otherwise
				r_boot_other[]
		endswitch

	rule r_ready_tick =
		switch svc(MAIL_SVC)
			case UP_SSTAT:
				par
					st := ORDER_ST
					orders := orders + 1
				endpar
			case SLOW_SSTAT:
				par
					st := WAITS_ST
					timer := 5
				endpar
			otherwise
				st := RECOVER_ST
		endswitch

	rule r_ready_req =
		if orders mod 3 = 0 or retries > 1 then
			par
				st := ORDER_ST
				retries := 0
				hist(READY_ST) := hist(READY_ST) + 1
			endpar
		else
			if timer >= 3 then
				par
					timer := timer - 3
					retries := retries + 1
				endpar
			else
				st := SHIP_ST
			endif
		endif

	rule r_ready_ack =
		if svc(BANK_SVC) = UP_SSTAT then
			par
				st := ORDER_ST
				calls(BANK_SVC) := (calls(BANK_SVC) + 1) mod 1000
				timer := 4
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(BANK_SVC) := (calls(BANK_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_ready_nack =
		if svc(AUTH_SVC) = DOWN_SSTAT then
			par
				st := RECOVER_ST
				errors := errors + 1
			endpar
		else
			if ticks mod 4 = 1 then
				par
					st := ORDER_ST
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				orders := orders + 1
			endif
		endif

	rule r_ready_tmo =
		if orders mod 5 = 0 or retries > 1 then
			par
				st := ORDER_ST
				retries := 0
				hist(READY_ST) := hist(READY_ST) + 1
			endpar
		else
			if timer >= 3 then
				par
					timer := timer - 3
					retries := retries + 1
				endpar
			else
				st := WAITS_ST
			endif
		endif

	rule r_ready_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_ready =
		switch ev
			case TICK_EV:
				r_ready_tick[]
			case REQ_EV:
				r_ready_req[]
			case ACK_EV:
				r_ready_ack[]
			case NACK_EV:
				r_ready_nack[]
			case TMO_EV:
				r_ready_tmo[]
			otherwise
				r_ready_other[]
		endswitch

	rule r_order_tick =
		if svc(STOCK_SVC) = UP_SSTAT then
			par
				st := PAY_ST
				calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
				timer := 5
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_order_req =
		if timer > 0 and svc(BANK_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(BANK_SVC) := (calls(BANK_SVC) + 1) mod 1000
			endpar
		else
			par
				st := FAILED_ST
				timer := 2
				hist(ORDER_ST) := hist(ORDER_ST) + 1
			endpar
		endif

	rule r_order_ack =
		if timer > 0 and svc(MAIL_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
			endpar
		else
			par
				st := ORDER_ST
				timer := 3
				hist(ORDER_ST) := hist(ORDER_ST) + 1
			endpar
		endif

	rule r_order_tmo =
		if timer > 0 and svc(AUTH_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
			endpar
		else
			par
				st := WAITS_ST
				timer := 4
				hist(ORDER_ST) := hist(ORDER_ST) + 1
			endpar
		endif

	rule r_order_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_order =
		switch ev
			case TICK_EV:
				r_order_tick[]
			case REQ_EV:
				r_order_req[]
			case ACK_EV:
				r_order_ack[]
			case TMO_EV:
				r_order_tmo[]
			otherwise
				r_order_other[]
		endswitch

	rule r_pay_tick =
		if svc(MAIL_SVC) = UP_SSTAT then
			par
				st := SHIP_ST
				calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
				timer := 5
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_pay_req =
		if timer > 0 and svc(AUTH_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
			endpar
		else
			par
				st := BOOT_ST
				timer := 5
				hist(PAY_ST) := hist(PAY_ST) + 1
			endpar
		endif

	rule r_pay_ack =
		if svc(MAIL_SVC) = UP_SSTAT then
			par
				st := SHIP_ST
				calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
				timer := 8
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_pay_nack =
		if svc(AUTH_SVC) = UP_SSTAT then
			par
				st := SHIP_ST
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				timer := 4
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_pay_tmo =
		if orders mod 5 = 0 or retries > 1 then
			par
				st := SHIP_ST
				retries := 0
				hist(PAY_ST) := hist(PAY_ST) + 1
			endpar
		else
			if timer >= 3 then
				par
					timer := timer - 3
					retries := retries + 1
				endpar
			else
				st := PAY_ST
			endif
		endif

	rule r_pay_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_pay =
		switch ev
			case TICK_EV:
				r_pay_tick[]
			case REQ_EV:
				r_pay_req[]
			case ACK_EV:
				r_pay_ack[]
			case NACK_EV:
				r_pay_nack[]
			case TMO_EV:
				r_pay_tmo[]
			otherwise
				r_pay_other[]
		endswitch

	rule r_ship_tick =
		if orders mod 4 = 0 or retries > 1 then
			par
				st := WAITS_ST
				retries := 0
				hist(SHIP_ST) := hist(SHIP_ST) + 1
			endpar
		else
			if timer >= 3 then
				par
					timer := timer - 3
					retries := retries + 1
				endpar
			else
				st := FAILED_ST
			endif
		endif

	rule r_ship_ack =
		if timer > 0 and svc(BANK_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(BANK_SVC) := (calls(BANK_SVC) + 1) mod 1000
			endpar
		else
			par
				st := RECOVER_ST
				timer := 5
				hist(SHIP_ST) := hist(SHIP_ST) + 1
			endpar
		endif

	rule r_ship_tmo =
		switch svc(STOCK_SVC)
			case UP_SSTAT:
				par
					st := WAITS_ST
					orders := orders + 1
				endpar
			case SLOW_SSTAT:
				par
					st := WAITS_ST
					timer := 5
				endpar
			otherwise
				st := RECOVER_ST
		endswitch

	rule r_ship_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_ship =
		switch ev
			case TICK_EV:
				r_ship_tick[]
			case ACK_EV:
				r_ship_ack[]
			case TMO_EV:
				r_ship_tmo[]
			otherwise
				r_ship_other[]
		endswitch

	rule r_waits_tick =
		if timer > 0 and svc(STOCK_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
			endpar
		else
			par
				st := SHIP_ST
				timer := 2
				hist(WAITS_ST) := hist(WAITS_ST) + 1
			endpar
		endif

	rule r_waits_req =
		switch svc(BANK_SVC)
			case UP_SSTAT:
				par
					st := RECOVER_ST
					orders := orders + 1
				endpar
			case SLOW_SSTAT:
				par
					st := WAITS_ST
					timer := 5
				endpar
			otherwise
				st := RECOVER_ST
		endswitch

	rule r_waits_ack =
		if svc(AUTH_SVC) = DOWN_SSTAT then
			par
				st := RECOVER_ST
				errors := errors + 1
			endpar
		else
			if ticks mod 4 = 1 then
				par
					st := RECOVER_ST
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				orders := orders + 1
			endif
		endif

	rule r_waits_nack =
		if svc(MAIL_SVC) = UP_SSTAT then
			par
				st := RECOVER_ST
				calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
				timer := 8
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(MAIL_SVC) := (calls(MAIL_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_waits_tmo =
		if svc(AUTH_SVC) = UP_SSTAT then
			par
				st := RECOVER_ST
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				timer := 4
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_waits_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_waits =
		switch ev
			case TICK_EV:
				r_waits_tick[]
			case REQ_EV:
				r_waits_req[]
			case ACK_EV:
				r_waits_ack[]
			case NACK_EV:
				r_waits_nack[]
			case TMO_EV:
				r_waits_tmo[]
			otherwise
				r_waits_other[]
		endswitch

	rule r_recover_tick =
		if svc(AUTH_SVC) = UP_SSTAT then
			par
				st := FAILED_ST
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				timer := 3
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_recover_req =
		if svc(BANK_SVC) = UP_SSTAT then
			par
				st := FAILED_ST
				calls(BANK_SVC) := (calls(BANK_SVC) + 1) mod 1000
				timer := 4
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(BANK_SVC) := (calls(BANK_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_recover_ack =
		if timer > 0 and svc(STOCK_SVC) != DOWN_SSTAT then
			par
				timer := timer - 1
				calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
			endpar
		else
			par
				st := SHIP_ST
				timer := 4
				hist(RECOVER_ST) := hist(RECOVER_ST) + 1
			endpar
		endif

	rule r_recover_nack =
		if orders mod 5 = 0 or retries > 1 then
			par
				st := FAILED_ST
				retries := 0
				hist(RECOVER_ST) := hist(RECOVER_ST) + 1
			endpar
		else
			if timer >= 3 then
				par
					timer := timer - 3
					retries := retries + 1
				endpar
			else
				st := FAILED_ST
			endif
		endif

	rule r_recover_tmo =
		if svc(AUTH_SVC) = UP_SSTAT then
			par
				st := FAILED_ST
				calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				timer := 6
			endpar
		else
			if retries < 3 then
				par
					retries := retries + 1
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				par
					st := RECOVER_ST
					retries := 0
					errors := errors + 1
				endpar
			endif
		endif

	rule r_recover_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_recover =
		switch ev
			case TICK_EV:
				r_recover_tick[]
			case REQ_EV:
				r_recover_req[]
			case ACK_EV:
				r_recover_ack[]
			case NACK_EV:
				r_recover_nack[]
			case TMO_EV:
				r_recover_tmo[]
			otherwise
				r_recover_other[]
		endswitch

	rule r_failed_tick =
		switch svc(STOCK_SVC)
			case UP_SSTAT:
				par
					st := BOOT_ST
					orders := orders + 1
				endpar
			case SLOW_SSTAT:
				par
					st := WAITS_ST
					timer := 5
				endpar
			otherwise
				st := RECOVER_ST
		endswitch

	rule r_failed_ack =
		if svc(STOCK_SVC) = DOWN_SSTAT then
			par
				st := RECOVER_ST
				errors := errors + 1
			endpar
		else
			if ticks mod 4 = 1 then
				par
					st := BOOT_ST
					calls(STOCK_SVC) := (calls(STOCK_SVC) + 1) mod 1000
				endpar
			else
				orders := orders + 1
			endif
		endif

	rule r_failed_nack =
		if svc(AUTH_SVC) = DOWN_SSTAT then
			par
				st := RECOVER_ST
				errors := errors + 1
			endpar
		else
			if ticks mod 4 = 1 then
				par
					st := BOOT_ST
					calls(AUTH_SVC) := (calls(AUTH_SVC) + 1) mod 1000
				endpar
			else
				orders := orders + 1
			endif
		endif

	rule r_failed_tmo =
		switch svc(STOCK_SVC)
			case UP_SSTAT:
				par
					st := BOOT_ST
					orders := orders + 1
				endpar
			case SLOW_SSTAT:
				par
					st := WAITS_ST
					timer := 5
				endpar
			otherwise
				st := RECOVER_ST
		endswitch

	rule r_failed_other =
		if ev = RST_EV then
			par
				st := BOOT_ST
				retries := 0
			endpar
		else
			skip
		endif

	rule r_in_failed =
		switch ev
			case TICK_EV:
				r_failed_tick[]
			case ACK_EV:
				r_failed_ack[]
			case NACK_EV:
				r_failed_nack[]
			case TMO_EV:
				r_failed_tmo[]
			otherwise
				r_failed_other[]
		endswitch

	main rule r_Main =
		par
			r_event[]
			r_timer[]
			forall $s in Svcdom with true do
				r_service[$s]
			switch st
				case BOOT_ST:
					r_in_boot[]
				case READY_ST:
					r_in_ready[]
				case ORDER_ST:
					r_in_order[]
				case PAY_ST:
					r_in_pay[]
				case SHIP_ST:
					r_in_ship[]
				case WAITS_ST:
					r_in_waits[]
				case RECOVER_ST:
					r_in_recover[]
				case FAILED_ST:
					r_in_failed[]
			endswitch
		endpar

default init s0:
	function st = BOOT_ST
	function ev = TICK_EV
	function seed = 1
	function retries = 0
	function timer = 0
	function ticks = 0
	function idle = 0
	function orders = 0
	function errors = 0
	function svc($s in Svcdom) = UP_SSTAT
	function calls($s in Svcdom) = 0
	function down($s in Svcdom) = 0
	function hist($z in Stdom) = 0
