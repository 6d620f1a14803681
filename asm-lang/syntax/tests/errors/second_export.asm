module second_export
export a
export b //~ L014
signature:
definitions:
