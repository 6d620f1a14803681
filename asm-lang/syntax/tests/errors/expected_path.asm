asm expected_path
import
signature: //~ L058
definitions:
