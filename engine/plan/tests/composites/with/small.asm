asm small
signature:
	enum domain Mode = {IDLE | BUSY}
	enum domain Action = {NOACT | GET_MAP | PLAN | FOLLOW | HALT}
	enum domain Ev = {NOEV | MAP_OK | PATH_OK | CALL_FAILED | REACHED}
	monitored goalArrived: Boolean
	monitored estop: Boolean
	monitored ev: Ev
	shared near: Mode -> Boolean
	out command: Action
	controlled mode: Mode
	controlled moving: Boolean
definitions:
	main rule r_Main = skip
