module second_export
export a
export b //~ L023
signature:
definitions:
