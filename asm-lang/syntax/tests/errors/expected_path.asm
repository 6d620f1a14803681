asm expected_path
import
signature: //~ L038
definitions:
