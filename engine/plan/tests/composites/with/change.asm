asm change
signature:
	out early: Boolean
	out late: Boolean
	out kept: Boolean
	out near: Boolean
	out every: Boolean
definitions:
	main rule r_Main = skip
